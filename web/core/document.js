// SPDX-License-Identifier: Apache-2.0
// EXR files with the lens that their headers name: what `rackfocus filter` makes of
// them, at preview quality while something is dragged, at best quality afterwards.

import { Module } from "./module.js";
import { encodePng } from "./png.js";
import { readParameters, toKey } from "./table.js";

/** What show() can show. */
export const SHOW = Object.freeze(
  { picture: 0, pinhole: 1, depth: 2, coc: 3, inFocus: 4 });

export class Document {
  #module;
  #handle = 0;
  #names = [];

  /**
   * Opens one file with colour and depth, two with one each, or views from points of
   * the lens. Throws what is wrong with them.
   * @param {{name: string, bytes: Uint8Array}[]} files
   * @param {{threads?: number}} how at most so many, where the page may have several
   */
  static async open(files, { threads } = {}) {
    const self = new Document();
    self.#module = await Module.load({ threads });
    self.parameters = readParameters(self.#module);
    self.#names = files.map(({ name }) => name);
    for (const { name, bytes } of files) self.#module.files.put(name, bytes);
    const { exports } = self.#module;
    self.#handle = self.#module.check(self.#module.withTexts(
      [self.#names.join("\0")], (names) => exports.rw_open(names, files.length, self.#module.threads)));
    self.#module.check(exports.rw_resolve(self.#handle));
    return self;
  }

  get width() { return this.#module.exports.rw_width(this.#handle); }
  get height() { return this.#module.exports.rw_height(this.#handle); }
  get threads() { return this.#module.threads; }
  get views() { return this.#module.exports.rw_n_views(this.#handle); }
  /** Of the finite depths, scene units. */
  get nearest() { return this.#module.exports.rw_nearest(this.#handle); }
  get farthest() { return this.#module.exports.rw_farthest(this.#handle); }
  /** What is doubtful of the file and what was done to its depth, or "". */
  get remark() { return this.#module.text(this.#module.exports.rw_remark(this.#handle)); }

  /** Of the module, with the pictures in it; it never shrinks. */
  get memoryBytes() { return this.#module.memoryBytes; }

  /** Called with 0 to 1 while the best picture is made; false cancels. */
  set onProgress(report) { this.#module.onProgress = report; }

  #ask(name, step) {
    return this.#module.text(
      this.#module.withTexts([toKey(name)], (key) => step(this.#handle, key)));
  }

  /** Sets these parameters and no others: the header gives the rest. */
  set(params) {
    const { exports } = this.#module;
    exports.rw_reset(this.#handle);
    for (const [name, value] of Object.entries(params))
      this.#module.check(this.#module.withTexts(
        [toKey(name), String(value)], (key, text) => exports.rw_set(this.#handle, key, text)));
    this.#module.check(exports.rw_resolve(this.#handle));
  }

  /** Every parameter: value as text, where it is from, why it is not read (or null). */
  describe() {
    const { exports } = this.#module;
    return this.parameters.map(({ name }) => ({
      name,
      value: this.#ask(name, exports.rw_get),
      origin: this.#ask(name, exports.rw_origin),
      whyUnused: this.#ask(name, exports.rw_why_unused),
    }));
  }

  /** Scene units along the axis at a pixel; Infinity where nothing was hit. */
  distanceAt(x, y) { return this.#module.exports.rw_distance_at(this.#handle, x, y); }
  /** Signed radius of the circle of confusion at a pixel, px. */
  radiusAt(x, y) { return this.#module.exports.rw_radius_at(this.#handle, x, y); }

  /** Makes the picture: the best, or one `times` smaller at preview quality. */
  render({ best = true, times = 1 } = {}) {
    this.#module.check(this.#module.exports.rw_render(this.#handle, best ? 1 : 0, times));
  }

  #image(pointer, width, height) {
    return { width, height, rgba: this.#module.bytes(pointer, 4 * width * height).slice() };
  }

  /** 8 bit RGBA of what was rendered, of the pinhole picture or of a map. */
  show(what = SHOW.picture, exposure = 0) {
    const { exports } = this.#module;
    const pointer = this.#module.check(exports.rw_show(this.#handle, what, exposure));
    if (what !== SHOW.picture) return this.#image(pointer, this.width, this.height);
    return this.#image(pointer, exports.rw_picture_width(this.#handle),
                       exports.rw_picture_height(this.#handle));
  }

  /** Another EXR file of the same size, as 8 bit RGBA. */
  showFile(name, bytes, exposure = 0) {
    const { exports } = this.#module;
    this.#module.files.put(name, bytes);
    try {
      const pointer = this.#module.check(this.#module.withTexts(
        [name], (path) => exports.rw_show_file(this.#handle, path, exposure)));
      const image = this.#image(pointer, this.width, this.height);
      this.#module.release(pointer);
      return image;
    } finally {
      this.#module.files.remove(name);
    }
  }

  /** Floats of the last picture, as they come. */
  pixels() {
    const { exports } = this.#module;
    const width = exports.rw_picture_width(this.#handle);
    const height = exports.rw_picture_height(this.#handle);
    const channels = exports.rw_n_channels(this.#handle);
    const data = this.#module.floats(exports.rw_pixels(this.#handle), width * height * channels);
    return { data: data.slice(), width, height, channels };
  }

  /** The best picture as the bytes of a PNG file. */
  async png() {
    this.render();
    const { exports } = this.#module;
    const { width, height } = this;
    const channels = exports.rw_n_channels(this.#handle);
    const pointer = this.#module.check(exports.rw_png_rows(this.#handle));
    const rows = this.#module.bytes(pointer, height * (1 + width * channels)).slice();
    this.#module.release(pointer);
    return encodePng(rows, width, height, channels);
  }

  /** The best picture as the bytes of an EXR file, half floats. */
  exr() {
    const name = "rackfocus-output.exr";
    this.#module.check(this.#module.withTexts(
      [name], (path) => this.#module.exports.rw_save(this.#handle, path)));
    const bytes = this.#module.files.get(name);
    this.#module.files.remove(name);
    return bytes;
  }

  /** Gives its memory back. */
  close() {
    this.#module.exports.rw_close(this.#handle);
    this.#module.end();
    this.#handle = 0;
  }
}
