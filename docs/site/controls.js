// SPDX-License-Identifier: Apache-2.0
// The panel: sliders of the lens, and a field for every parameter of the table.

/** The lens in a few sliders; of the two ways to give its width the one that is read. */
const MAIN = ["focusDistance", "fStop", "lensRadius", "focalLength", "blades", "bladeRotation",
              "bladeCurvature", "apertureRatio", "catEye", "spherical", "axialChroma", "swirl"];
const LABELS = {
  focusDistance: "Focus distance", fStop: "f-stop", lensRadius: "Lens radius",
  focalLength: "Focal length", blades: "Blades", bladeRotation: "Rotation of the blades",
  bladeCurvature: "Curvature of the blades", apertureRatio: "Anamorphic ratio",
  catEye: "Cat's eyes", spherical: "Spherical aberration", axialChroma: "Longitudinal colour",
  swirl: "Swirl",
};
const RANGES = { // where the table's range is wider than what anyone wants to see
  fStop: [0.5, 32], focalLength: [8, 300], blades: [0, 12], apertureRatio: [0.5, 2],
  bladeRotation: [0, 90], spherical: [-20, 20], axialChroma: [-10, 10], swirl: [-1, 1],
};
const LOGARITHMIC = new Set(["focusDistance", "fStop", "lensRadius", "focalLength", "apertureRatio"]);
const STEPS = 1000;

const element = (tag, content = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), content);
  made.append(...children);
  return made;
};

/** Units as one reads them; "1" and counts need none. */
const UNITS = { "scene units": "", 1: "", "f-number": "", blades: "", degrees: "°", px: " px",
                mm: " mm" };

const short = (value) => String(Number(Number(value).toPrecision(4)));

export class Controls {
  #panel;
  #on;
  #rows = new Map();
  #ranges = {};
  table = [];
  picture = null;

  constructor(panel, on) {
    this.#panel = panel;
    this.#on = on;
  }

  /** Builds the panel for a picture that was opened. */
  open(picture) {
    this.picture = picture;
    this.table = picture.table;
    this.#rows.clear();
    const values = new Map(picture.values.map((v) => [v.name, v.value]));
    const radius = Number(values.get("lensRadius"));
    this.#ranges = {
      ...RANGES,
      focusDistance: [picture.nearest / 1.5, Math.max(picture.farthest * 1.5, picture.nearest * 4)],
      lensRadius: radius > 0 ? [radius / 32, radius * 4] : [1e-4, 1],
    };
    const names = MAIN.filter((name) => this.table.some((p) => p.name === name));
    const main = names.map((name) => this.#slider(this.table.find((p) => p.name === name)));
    const groups = [...new Set(this.table.map((p) => p.group))];
    const all = groups.flatMap((group) => [
      element("h2", { textContent: group[0].toUpperCase() + group.slice(1) }),
      ...this.table.filter((p) => p.group === group).map((p) => this.#field(p)),
    ]);
    this.#panel.replaceChildren(element("h2", { textContent: "The lens" }), ...main,
      this.#exposure(),
      element("details", {}, element("summary", { textContent: "All parameters" }), ...all));
    this.update(picture.values);
  }

  /** Shows the values; greys out what is not read, and says why. */
  update(values) {
    for (const value of values)
      for (const row of this.#rows.get(value.name) ?? []) row(value);
  }

  #add(name, row) {
    this.#rows.set(name, [...(this.#rows.get(name) ?? []), row]);
  }

  #slider(parameter) {
    const { name, unit, help } = parameter;
    const [low, high] = this.#ranges[name] ?? [parameter.min, parameter.max];
    const isLog = LOGARITHMIC.has(name), isWhole = parameter.type === "int";
    const toValue = (at) => (isLog ? low * (high / low) ** (at / STEPS)
                                   : low + (high - low) * at / STEPS);
    const toPlace = (value) => STEPS * (isLog ? Math.log(value / low) / Math.log(high / low)
                                              : (value - low) / (high - low));
    const input = element("input", { type: "range", min: 0, max: STEPS, id: `slider-${name}` });
    const output = element("output", { htmlFor: input.id });
    const label = element("label", { title: help },
      element("span", {}, LABELS[name] ?? name, output), input);
    input.oninput = () => {
      const value = toValue(Number(input.value));
      this.#on.change(name, isWhole ? Math.round(value) : Number(value.toPrecision(4)));
    };
    this.#add(name, ({ value, whyUnused }) => {
      if (document.activeElement !== input || !input.matches(":active"))
        input.value = Math.min(STEPS, Math.max(0, toPlace(Number(value))));
      output.value = `${name === "fStop" ? "f/" : ""}${short(value)}${UNITS[unit] ?? ` ${unit}`}`;
      input.setAttribute("aria-valuetext", output.value);
      label.classList.toggle("unused", whyUnused !== null);
      label.hidden = (name === "fStop" || name === "lensRadius") && whyUnused !== null;
      label.title = whyUnused === null ? help : `${help} Now: ${whyUnused}.`;
    });
    return label;
  }

  #input({ name, type, choices }) {
    if (type === "enum") {
      const select = element("select", {}, ...choices.map((c) => new Option(c, c)));
      select.onchange = () => this.#on.change(name, select.value);
      return [select, (value) => { select.value = value; }];
    }
    if (type === "bool") {
      const box = element("input", { type: "checkbox" });
      box.onchange = () => this.#on.change(name, box.checked);
      return [box, (value) => { box.checked = value === "true"; }];
    }
    const text = element("input", { type: "text", inputMode: "decimal" });
    text.onchange = () => this.#on.change(name, text.value.trim() === "" ? null : text.value.trim());
    return [text, (value) => {
      if (document.activeElement !== text) text.value = short(value);
    }];
  }

  #field(parameter) {
    const [input, set] = this.#input(parameter);
    const unit = parameter.unit ? ` (${parameter.unit})` : "";
    const label = element("label", {},
      element("span", {}, `--${parameter.key}${unit}`, input));
    this.#add(parameter.name, ({ value, origin, whyUnused }) => {
      set(value);
      label.classList.toggle("unused", whyUnused !== null);
      label.title = `${parameter.help} From: ${origin}.` +
        (whyUnused === null ? "" : ` Without effect: ${whyUnused}.`);
    });
    return label;
  }

  #exposure() {
    const input = element("input", { type: "range", min: -6, max: 6, step: 0.1, value: 0 });
    const output = element("output", { value: "0 stops" });
    input.oninput = () => {
      output.value = `${short(input.value)} stops`;
      this.#on.exposure(Number(input.value));
    };
    return element("label", { title: "Of the screen only; saved pictures do not change." },
      element("span", {}, "Exposure of the screen", output), input);
  }
}
