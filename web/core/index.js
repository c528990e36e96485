// SPDX-License-Identifier: Apache-2.0
// @rackfocus/core: depth of field after the render, in WebAssembly.

import { Module } from "./module.js";
import { readParameters, toKey } from "./table.js";

const core = await Module.load();
const context = core.check(core.exports.rw_context_new(core.threads));

export const version = core.text(core.exports.rw_version());
export const parameters = Object.freeze(readParameters(core));

/** One view as the module wants it, checked. */
function checkView(view, like) {
  const { colour, depth } = view;
  const { data, width, height, channels } = colour;
  if (![1, 3, 4].includes(channels))
    throw new RangeError(`colour: ${channels} channels; 1, 3 or 4 can be filtered`);
  if (data.length !== width * height * channels)
    throw new RangeError(`colour: ${data.length} floats are not ${width} x ${height} x ${channels}`);
  const plane = depth.data ?? depth;
  if (plane.length !== width * height)
    throw new RangeError(`depth: ${plane.length} floats are not ${width} x ${height}`);
  if (like && (like.width !== width || like.height !== height || like.channels !== channels))
    throw new RangeError("views: all must have the size and the channels of the first");
  return { data, plane, width, height, channels };
}

/** A lens and a way to blur with it. */
export class Filter {
  #params;
  #filter = 0;
  #size = "";

  /** @param {import("./index.js").Params} params names of the table, in camel case */
  constructor(params = {}) {
    this.#params = core.exports.rw_params_new();
    for (const [name, value] of Object.entries(params)) {
      if (value === undefined) continue;
      if (!parameters.some((p) => p.name === name))
        throw new RangeError(`${name}: there is no such parameter`);
      core.check(core.withTexts([toKey(name), String(value)],
                                (key, text) => core.exports.rw_params_set(this.#params, key, text)));
    }
  }

  /** Why a parameter has no effect with these; null: it has. */
  whyNotRead(name) {
    return core.withTexts([toKey(name)],
                          (key) => core.text(core.exports.rw_why_not_read(this.#params, key)));
  }

  #prepare(width, height) {
    const size = `${width} x ${height}`;
    if (this.#size === size) return;
    core.exports.rw_filter_free(this.#filter);
    this.#size = "";
    this.#filter = core.check(core.exports.rw_filter_new(context, this.#params, width, height));
    this.#size = size;
  }

  /** The picture that the lens makes of a pinhole picture and its depth, or of views. */
  apply(colour, depth) {
    const views = Array.isArray(colour) ? colour : [{ colour, depth }];
    const first = checkView(views[0]);
    const { width, height, channels } = first;
    const n = width * height, nFloats = n * channels;
    this.#prepare(width, height);
    const pointers = [nFloats * views.length, n * views.length, nFloats, 6 * views.length]
      .map((count) => core.allocate(4 * count));
    const [colours, depths, out, places] = pointers;
    try {
      views.forEach((view, i) => {
        const { data, plane } = checkView(view, first);
        core.floats(colours + 4 * i * nFloats, nFloats).set(data);
        core.floats(depths + 4 * i * n, n).set(plane);
        core.doubles(places + 24 * i, 3)
          .set([...(view.lensOffset ?? [0, 0]), view.shearDistance ?? 0]);
      });
      core.check(core.exports.rw_filter_apply(this.#filter, width, height, channels,
                                              views.length, colours, depths, places, out));
      return { data: core.floats(out, nFloats).slice(), width, height, channels };
    } finally {
      core.release(...pointers);
    }
  }

  /** Signed radii of the circles of confusion, px: positive behind the focus. */
  coc(depth, width, height) {
    const { plane } = checkView({ colour: { data: depth, width, height, channels: 1 }, depth });
    this.#prepare(width, height);
    const n = width * height, pointer = core.allocate(4 * n);
    try {
      core.floats(pointer, n).set(plane);
      core.check(core.exports.rw_filter_coc(this.#filter, width, height, pointer, pointer));
      return core.floats(pointer, n).slice();
    } finally {
      core.release(pointer);
    }
  }

  /** Gives its memory back; it cannot be used afterwards. */
  free() {
    core.exports.rw_filter_free(this.#filter);
    core.release(this.#params);
    this.#filter = this.#params = 0;
  }
}
