// SPDX-License-Identifier: Apache-2.0
// Search in all pages: sections that have every word, those with it in the heading first.

const field = document.getElementById("search");
const results = document.getElementById("results");
const content = document.getElementById("content");
const MOST = 30, AROUND = 80;
let index = null;

function rank([, title, heading, text], words) {
  const head = `${title} ${heading}`.toLowerCase(), body = text.toLowerCase();
  if (!words.every((word) => head.includes(word) || body.includes(word))) return 0;
  return 1 + words.filter((word) => head.includes(word)).length;
}

function excerpt(text, word) {
  const at = text.toLowerCase().indexOf(word);
  if (at < 0) return [text.slice(0, 2 * AROUND)];
  const mark = document.createElement("mark");
  mark.textContent = text.slice(at, at + word.length);
  return [`… ${text.slice(Math.max(0, at - AROUND), at)}`, mark,
          `${text.slice(at + word.length, at + word.length + AROUND)} …`];
}

function show(section, words) {
  const [place, title, heading, text] = section;
  const link = Object.assign(document.createElement("a"), { href: place });
  link.textContent = heading === title ? title : `${title}: ${heading}`;
  const line = document.createElement("p");
  line.append(...excerpt(text, words[0]));
  const item = document.createElement("section");
  item.append(link, line);
  return item;
}

field.oninput = async () => {
  index ??= await (await fetch("search.json")).json();
  const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
  content.hidden = words.length > 0;
  const found = index.map((section) => [rank(section, words), section])
    .filter(([weight]) => words.length > 0 && weight > 0)
    .sort((a, b) => b[0] - a[0]).slice(0, MOST);
  results.replaceChildren(...found.map(([, section]) => show(section, words)));
  if (words.length > 0 && found.length === 0) results.textContent = "Nothing was found.";
};
