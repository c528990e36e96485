// SPDX-License-Identifier: Apache-2.0
// The lesson: formulas with a slider for every letter, methods side by side.

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 520, HEIGHT = 320, EDGE = 40;

const letters = [
  { id: "s", label: "Focus distance s", unit: "m", low: 0.3, high: 30, value: 3 },
  { id: "N", label: "f-number N", unit: "", low: 1, high: 22, value: 2.8 },
  { id: "f", label: "Focal length f", unit: "mm", low: 14, high: 200, value: 50 },
  { id: "sensor", label: "Sensor width", unit: "mm", low: 6, high: 54, value: 36 },
  { id: "width", label: "Picture width", unit: "px", low: 480, high: 8192, value: 1920 },
  { id: "c", label: "Largest sharp radius c", unit: "px", low: 0.25, high: 4, value: 1 },
];
const value = Object.fromEntries(letters.map(({ id, value: start }) => [id, start]));

const short = (number) => (Number.isFinite(number) ? String(Number(number.toPrecision(3))) : "∞");

function draw(tag, attributes, text) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, content] of Object.entries(attributes)) made.setAttribute(name, content);
  if (text !== undefined) made.textContent = text;
  return made;
}

function constants() {
  const radius = value.f / (2 * value.N) / 1000;
  const px = value.f / value.sensor * value.width;
  return { K: radius * px };
}

/** Distances are drawn logarithmically from 0.2 to 100 m. */
const placeX = (z) => EDGE + (WIDTH - 2 * EDGE) * Math.log(z / 0.2) / Math.log(500);

function curve(K, most) {
  const middle = HEIGHT / 2, points = [];
  for (let i = 0; i <= 400; i++) {
    const z = 0.2 * 500 ** (i / 400), r = K * (1 / value.s - 1 / z);
    const y = middle - Math.max(-1, Math.min(1, r / most)) * (middle - 20);
    points.push(`${placeX(z).toFixed(1)},${y.toFixed(1)}`);
  }
  return points.join(" ");
}

function drawGraph() {
  const { K } = constants();
  const most = Math.max(4 * value.c, K / value.s);
  const near = 1 / (1 / value.s + value.c / K), far = 1 / Math.max(0, 1 / value.s - value.c / K);
  const svg = draw("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img",
    "aria-label": "Signed radius over the distance" });
  const left = Math.max(EDGE, placeX(near)), right = Math.min(WIDTH - EDGE, placeX(Math.min(far, 100)));
  svg.append(draw("rect", { x: left, y: 10, width: Math.max(0, right - left), height: HEIGHT - 20,
                            fill: "#f2a33a", "fill-opacity": 0.2 }));
  svg.append(draw("line", { x1: EDGE, x2: WIDTH - EDGE, y1: HEIGHT / 2, y2: HEIGHT / 2, stroke: "#a6a9ad" }));
  svg.append(draw("line", { x1: placeX(value.s), x2: placeX(value.s), y1: 10, y2: HEIGHT - 10,
                            stroke: "#f2a33a", "stroke-dasharray": "4 4" }));
  svg.append(draw("polyline", { points: curve(K, most), fill: "none", stroke: "#7db7ff", "stroke-width": 2.5 }));
  for (const z of [0.2, 1, 3, 10, 30, 100])
    svg.append(draw("text", { x: placeX(z), y: HEIGHT / 2 + 16, fill: "#a6a9ad", "font-size": 11,
                              "text-anchor": "middle" }, `${z} m`));
  svg.append(draw("text", { x: EDGE, y: 16, fill: "#a6a9ad", "font-size": 11 }, `+${short(most)} px, behind`));
  svg.append(draw("text", { x: EDGE, y: HEIGHT - 8, fill: "#a6a9ad", "font-size": 11 }, `−${short(most)} px, before`));
  document.getElementById("coc-graph").replaceChildren(svg);
  document.getElementById("dof").textContent =
    `K = ${short(K)} px m; at infinity the radius is ${short(K / value.s)} px. Sharp from ` +
    `${short(near)} m to ${short(far)} m; hyperfocal distance ${short(K / value.c)} m.`;
}

function makeSliders() {
  for (const { id, label, unit, low, high } of letters) {
    const output = document.createElement("output");
    const input = Object.assign(document.createElement("input"),
                                { type: "range", min: 0, max: 1000, id: `letter-${id}` });
    const line = document.createElement("label"), head = document.createElement("span");
    head.append(label, " ", output);
    line.append(head, input);
    const show = () => { output.value = `${short(value[id])} ${unit}`; };
    input.value = 1000 * Math.log(value[id] / low) / Math.log(high / low);
    input.oninput = () => {
      value[id] = low * (high / low) ** (input.value / 1000);
      show();
      drawGraph();
    };
    show();
    document.getElementById("coc-controls").append(line);
  }
}

// ---- the methods -----------------------------------------------------------------

const find = (id) => document.getElementById(id);
const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
let picture = null, number = 0, isBusy = false, isDue = false;
const waiting = new Map();

worker.onmessage = ({ data }) => {
  if ("progress" in data) return;
  waiting.get(data.id)(data);
  waiting.delete(data.id);
};

function ask(type, content) {
  const id = ++number;
  worker.postMessage({ id, type, ...content });
  return new Promise((resolve) => waiting.set(id, resolve));
}

function parameters() {
  const [low, high] = [picture.nearest, picture.farthest];
  const radius = Number(picture.values.find(({ name }) => name === "lensRadius").value);
  return {
    method: find("method").value,
    focusDistance: (low * (high / low) ** (find("focus").value / 1000)).toPrecision(4),
    lensRadius: (radius * 4 * find("aperture").value / 1000).toPrecision(4),
  };
}

async function refresh() {
  if (isBusy) {
    isDue = true;
    return;
  }
  isBusy = true;
  const answer = await ask("render", { params: parameters(), best: true, show: "picture", exposure: 0 });
  if (answer.error) {
    find("method-text").textContent = answer.error;
  } else {
    const { width, height, rgba } = answer.image;
    const canvas = find("method-canvas");
    Object.assign(canvas, { width, height });
    canvas.getContext("2d").putImageData(new ImageData(rgba, width, height), 0, 0);
    find("method-text").textContent = `${find("method").value}: ${Math.round(answer.ms)} ms on one thread`;
  }
  isBusy = false;
  if (isDue) {
    isDue = false;
    refresh();
  }
}

async function startMethods() {
  const name = "posts_pinhole.exr";
  const bytes = new Uint8Array(await (await fetch(`samples/${name}`)).arrayBuffer());
  picture = await ask("open", { files: [{ name, bytes }] });
  const methods = picture.table.find((row) => row.name === "method").choices;
  // Those of several views have none here.
  find("method").append(...methods.filter((m) => !["views", "accumulate"].includes(m))
    .map((m) => new Option(m, m)));
  for (const id of ["method", "focus", "aperture"]) find(id).oninput = refresh;
  refresh();
}

makeSliders();
drawGraph();
startMethods();
