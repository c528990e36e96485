// SPDX-License-Identifier: Apache-2.0
// The core's table of parameters: keys as on the command line, names in camel case.

export const toKey = (name) => name.replace(/[A-Z]/g, (c) => `-${c.toLowerCase()}`);
export const toName = (key) => key.replace(/-(.)/g, (_, c) => c.toUpperCase());

function readDefault(type, text, choices) {
  if (type === "enum") return choices[Number(text)];
  return type === "bool" ? text === "1" : Number(text);
}

function readRow(row) {
  const [key, type, unit, min, max, value, group, list, help] = row.split("\t");
  const choices = list ? list.split(",") : [];
  return {
    name: toName(key), key, type, unit, group, help, choices,
    min: Number(min), max: Number(max), default: readDefault(type, value, choices),
  };
}

/** All parameters, in the order of the table. */
export function readParameters(module) {
  const rows = [];
  for (let i = 0; ; i++) {
    const row = module.text(module.exports.rw_param_row(i));
    if (row === null) return rows;
    rows.push(readRow(row));
  }
}
