// SPDX-License-Identifier: Apache-2.0
// "Try it": click to focus, drag the lens's sliders, compare, save.

import { Controls } from "./controls.js";
import { Stage } from "./stage.js";

const SHOWS = { picture: "Picture", pinhole: "Pinhole", depth: "Depth", coc: "Blur",
                inFocus: "In focus" };

const find = (id) => document.getElementById(id);

/** A worker that answers in order; of renders only the newest is done. */
class Renderer {
  #worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  #waiting = new Map();
  #number = 0;
  #busy = false;
  #next = null;
  onProgress = () => {};

  constructor() {
    this.#worker.onmessage = ({ data }) => {
      if ("progress" in data) {
        this.onProgress(data.progress);
        return;
      }
      const { resolve, reject } = this.#waiting.get(data.id);
      this.#waiting.delete(data.id);
      if (data.error) reject(new Error(data.error));
      else resolve(data);
    };
    this.#worker.onerror = (event) => {
      const error = new Error(event.message || "the filter could not be loaded");
      for (const { reject } of this.#waiting.values()) reject(error);
      this.#waiting.clear();
    };
  }

  ask(type, content = {}) {
    const id = ++this.#number;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, type, ...content });
    });
  }

  /** Renders; what is asked for meanwhile replaces what waits. */
  async render(content, done, failed) {
    if (this.#busy) {
      this.#next = [content, done, failed];
      return;
    }
    this.#busy = true;
    try {
      done(await this.ask("render", content));
    } catch (error) {
      failed(error);
    }
    this.#busy = false;
    const next = this.#next;
    this.#next = null;
    if (next) this.render(...next);
  }

  forget() {
    this.#next = null;
  }
}

const quick = new Renderer();
const best = new Renderer();
const stage = new Stage(find("canvas"));
const state = { params: {}, show: "picture", exposure: 0, files: [], reference: null,
                is_open: false, revision: 0, best: 0 };
let restTimer = 0;

function say(text, isBad = false) {
  find("status").textContent = text;
  find("status").classList.toggle("bad", isBad);
}

const round = (value, digits = 3) =>
  Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : "infinity";

function quote(word) {
  return /^[\w./+=,:@%-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;
}

function showCommand() {
  const words = ["rackfocus", "filter", ...state.files.map(({ name }) => name), "-o", "out.png"];
  for (const { key, name, type } of controls.table) {
    if (!(name in state.params)) continue;
    if (type === "bool") words.push(`--${state.params[name] ? "" : "no-"}${key}`);
    else words.push(`--${key}`, String(state.params[name]));
  }
  find("command").textContent = words.map(quote).join(" ");
}

// ---- rendering -------------------------------------------------------------------

function receive(answer, revision) {
  // A preview may come after the final picture.
  if (revision !== state.revision || (state.best === revision && !answer.best)) return;
  if (answer.best) state.best = revision;
  stage.show(answer.image, answer.best);
  controls.update(answer.values);
  const { width, height } = controls.picture;
  const method = answer.values.find((p) => p.name === "method").value;
  const what = state.show === "picture" ? `${method}, ${answer.best ? "final" : "preview"}`
                                        : SHOWS[state.show].toLowerCase();
  say(`${width} × ${height} px · ${what} · ${Math.round(answer.ms)} ms` +
      (controls.picture.remark ? ` · ${controls.picture.remark}` : ""));
  document.body.dataset.state = answer.best ? "best" : "preview";
}

function fail(error) {
  say(error.message, true);
  document.body.dataset.state = "failed";
}

function renderBest(revision) {
  const busy = find("busy");
  best.onProgress = (fraction) => { busy.style.width = `${100 * fraction}%`; };
  best.render({ params: { ...state.params }, best: true, show: state.show,
                exposure: state.exposure },
              (answer) => {
                busy.style.width = "0";
                receive(answer, revision);
              }, fail);
}

/** Something has changed: a preview at once, the final picture when nothing follows. */
function refresh() {
  if (!state.is_open) return;
  const revision = ++state.revision;
  document.body.dataset.state = "busy";
  showCommand();
  clearTimeout(restTimer);
  best.forget();
  quick.render({ params: { ...state.params }, best: false, show: state.show,
                 exposure: state.exposure },
               (answer) => receive(answer, revision), fail);
  restTimer = setTimeout(() => renderBest(revision), 150);
}

const controls = new Controls(find("panel"), {
  change(name, value) {
    if (value === null) delete state.params[name];
    else state.params[name] = value;
    refresh();
  },
  exposure(value) {
    state.exposure = value;
    refresh();
    showAgainst();
  },
});

// ---- opening ---------------------------------------------------------------------

function enable(isOn) {
  for (const id of ["save-png", "save-exr", "copy", "reset"]) find(id).disabled = !isOn;
}

async function openFiles(files, params = {}, reference = null) {
  say(`Opening ${files.map(({ name }) => name).join(", ")} …`);
  document.body.dataset.state = "busy";
  state.revision++;
  try {
    const [picture] = await Promise.all([quick.ask("open", { files }),
                                         best.ask("open", { files })]);
    Object.assign(state, { files, params, reference, is_open: true });
    document.body.dataset.threads = picture.threads;
    controls.open(picture);
    stage.open(picture.width, picture.height);
    enable(true);
    listAgainst();
    await showAgainst();
    refresh();
  } catch (error) {
    state.is_open = false;
    enable(false);
    if (/ --(depth|layer)/.test(error.message))
      error.message += ". Options are those of the command rackfocus; this page has none.";
    fail(error);
  }
}

async function readFile(file) {
  return { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
}

async function openLocal(list) {
  const files = await Promise.all([...list].map(readFile));
  files.sort((a, b) => (a.name < b.name ? -1 : 1));
  find("sample").value = "";
  if (files.length > 0) await openFiles(files);
}

async function fetchFile(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(`${path}: ${answer.status} ${answer.statusText}`);
  return { name: path.split("/").pop(), bytes: new Uint8Array(await answer.arrayBuffer()) };
}

async function openSample(sample) {
  try {
    say(`Loading ${sample.label} …`);
    const paths = sample.files.map((name) => `samples/${name}`);
    const files = await Promise.all(paths.map(fetchFile));
    const reference = sample.reference ? await fetchFile(`samples/${sample.reference}`) : null;
    await openFiles(files, { ...sample.params }, reference);
  } catch (error) {
    fail(error);
  }
}

// ---- the wipe --------------------------------------------------------------------

function listAgainst() {
  const select = find("against");
  const choices = [["", "nothing"], ["pinhole", "the pinhole picture"]];
  if (state.reference) choices.push(["reference", "the renderer's own lens"]);
  const kept = choices.some(([value]) => value === select.value) ? select.value : "";
  select.replaceChildren(...choices.map(([value, text]) => new Option(text, value)));
  select.value = kept;
}

async function showAgainst() {
  const kind = find("against").value;
  find("wipe").disabled = kind === "";
  if (!state.is_open) return;
  try {
    const exposure = state.exposure;
    const answer =
      kind === "pinhole" ? await quick.ask("pinhole", { exposure })
      : kind === "reference" ? await quick.ask("other", { file: state.reference, exposure })
      : { image: null };
    stage.compare(answer.image, Number(find("wipe").value));
  } catch (error) {
    fail(error);
  }
}

// ---- saving ----------------------------------------------------------------------

function download(bytes, name, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

async function save(kind, type) {
  try {
    const { bytes } = await best.ask("save", { params: { ...state.params }, kind });
    const stem = state.files[0].name.replace(/\.exr$/i, "");
    download(bytes, `${stem}_lens.${kind}`, type);
    say(`Saved ${stem}_lens.${kind}, ${(bytes.length / 1e6).toFixed(1)} MB`);
  } catch (error) {
    fail(error);
  }
}

// ---- what the hands do -----------------------------------------------------------

async function focusAt(x, y) {
  if (!state.is_open) return;
  const { distance } = await quick.ask("probe", { x, y });
  if (!Number.isFinite(distance)) {
    say("Nothing is there to focus on: the depth is infinite.");
    return;
  }
  state.params.focusDistance = Number(distance.toPrecision(6));
  refresh();
}

stage.onPick = focusAt;
stage.onPoint = async (x, y) => {
  if (!state.is_open || state.probing) return;
  state.probing = true;
  const { distance, radius } = await quick.ask("probe", { x, y });
  state.probing = false;
  stage.title(`${x}, ${y}: distance ${round(distance)}, blur ${round(Math.abs(radius))} px` +
              (radius < 0 ? " before" : radius > 0 ? " behind" : ""));
};

function makeShows() {
  for (const [show, label] of Object.entries(SHOWS)) {
    const button = document.createElement("button");
    button.textContent = label;
    button.dataset.show = show;
    button.setAttribute("aria-pressed", String(show === state.show));
    button.onclick = () => {
      state.show = show;
      for (const other of find("shows").children)
        other.setAttribute("aria-pressed", String(other === button));
      refresh();
    };
    find("shows").append(button);
  }
}

function connect() {
  find("open").onclick = () => find("files").click();
  find("files").onchange = async ({ target }) => {
    await openLocal(target.files);
    target.value = ""; // so that the same file can be chosen again
  };
  find("fit").onclick = () => stage.fit();
  find("one").onclick = () => stage.magnify(1);
  find("against").onchange = showAgainst;
  find("wipe").oninput = ({ target }) => stage.wipe(Number(target.value));
  find("save-png").onclick = () => save("png", "image/png");
  find("save-exr").onclick = () => save("exr", "image/x-exr");
  find("reset").onclick = () => {
    state.params = {};
    refresh();
  };
  find("copy").onclick = async () => {
    await navigator.clipboard.writeText(find("command").textContent);
    say("The command line is copied.");
  };
  const area = find("stage");
  area.ondragover = (event) => {
    event.preventDefault();
    area.classList.add("over");
  };
  area.ondragleave = () => area.classList.remove("over");
  area.ondrop = (event) => {
    event.preventDefault();
    area.classList.remove("over");
    openLocal(event.dataTransfer.files);
  };
}

async function start() {
  makeShows();
  connect();
  const samples = await (await fetch("samples/samples.json")).json();
  const select = find("sample");
  select.append(new Option("a file of yours", "", false, false));
  for (const sample of samples) select.append(new Option(sample.label, sample.id));
  select.onchange = () => {
    const sample = samples.find(({ id }) => id === select.value);
    if (sample) openSample(sample);
  };
  const asked = new URLSearchParams(location.search).get("sample");
  const first = samples.find(({ id }) => id === asked) ?? samples[0];
  select.value = first.id;
  await openSample(first);
}

start().catch(fail);
