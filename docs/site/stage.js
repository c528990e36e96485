// SPDX-License-Identifier: Apache-2.0
// The canvas: the picture, zoomed and moved, with a wipe against another one.

const MOST = 16;

/** A canvas that holds 8 bit pixels. */
function hold({ width, height, rgba }) {
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(new ImageData(rgba, width, height), 0, 0);
  return canvas;
}

export class Stage {
  #canvas;
  #picture = null;
  #other = null;
  #split = 0.5;
  #size = [480, 270];
  #zoom = { scale: 1, x: 0, y: 0, isFitted: true }; // px of the canvas = scale p + (x, y)
  #pointers = new Map();
  #start = null;
  #cross = null;
  #isDue = false;
  onPick = () => {};
  onPoint = () => {};

  constructor(canvas) {
    this.#canvas = canvas;
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    for (const type of ["pointerdown", "pointermove", "pointerup", "pointercancel"])
      canvas.addEventListener(type, (event) => this.#pointer(event));
    canvas.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
  }

  open(width, height) {
    this.#size = [width, height];
    this.#picture = this.#other = this.#cross = null;
    this.#zoom.isFitted = true;
    this.#resize();
  }

  show(image) {
    this.#picture = hold(image);
    this.#draw();
  }

  compare(image, split) {
    this.#other = image && hold(image);
    this.wipe(split);
  }

  wipe(split) {
    this.#split = split;
    this.#draw();
  }

  title(text) {
    this.#canvas.title = text;
  }

  fit() {
    this.#zoom.isFitted = true;
    this.#resize();
  }

  /** Canvas px per px of the picture, the middle staying. */
  magnify(scale) {
    const { width, height } = this.#canvas;
    this.#zoomTo(scale, width / 2, height / 2);
  }

  /** As the page has room: its width, and at most most of its height. */
  #resize() {
    const [width, height] = this.#size;
    const room = this.#canvas.parentElement.clientWidth;
    const shown = Math.min(room * height / width, 0.75 * innerHeight);
    const density = devicePixelRatio || 1;
    this.#canvas.style.height = `${Math.round(shown)}px`;
    this.#canvas.width = Math.round(room * density);
    this.#canvas.height = Math.round(shown * density);
    if (this.#zoom.isFitted) {
      const scale = Math.min(this.#canvas.width / width, this.#canvas.height / height);
      this.#zoom = { scale, isFitted: true, x: (this.#canvas.width - scale * width) / 2,
                     y: (this.#canvas.height - scale * height) / 2 };
    }
    this.#draw();
  }

  #zoomTo(scale, x, y) {
    const old = this.#zoom, least = Math.min(1, 0.5 * this.#canvas.width / this.#size[0]);
    const next = Math.min(MOST, Math.max(least, scale)), by = next / old.scale;
    // Whole px: at 1:1 the canvas has the picture's own values.
    this.#zoom = { scale: next, isFitted: false, x: Math.round(x - by * (x - old.x)),
                   y: Math.round(y - by * (y - old.y)) };
    this.#draw();
  }

  #place(event) {
    const box = this.#canvas.getBoundingClientRect();
    const density = this.#canvas.width / box.width;
    return [(event.clientX - box.left) * density, (event.clientY - box.top) * density];
  }

  /** The pixel of the picture under a place of the canvas, or null. */
  #pixel([x, y]) {
    const px = Math.floor((x - this.#zoom.x) / this.#zoom.scale);
    const py = Math.floor((y - this.#zoom.y) / this.#zoom.scale);
    const [width, height] = this.#size;
    return px >= 0 && py >= 0 && px < width && py < height ? [px, py] : null;
  }

  #wheel(event) {
    event.preventDefault();
    this.#zoomTo(this.#zoom.scale * 1.2 ** (-Math.sign(event.deltaY)), ...this.#place(event));
  }

  #pointer(event) {
    const at = this.#place(event);
    if (event.type === "pointerdown") {
      this.#canvas.setPointerCapture(event.pointerId);
      this.#pointers.set(event.pointerId, at);
      this.#start = this.#pointers.size === 1 ? at : null;
    } else if (event.type === "pointermove") {
      this.#move(event.pointerId, at);
    } else {
      this.#pointers.delete(event.pointerId);
      const pixel = event.type === "pointerup" && this.#start && this.#pixel(this.#start);
      this.#start = null;
      if (pixel) this.onPick(...pixel);
    }
  }

  #move(id, at) {
    const old = this.#pointers.get(id);
    if (!old) {
      const pixel = this.#pixel(at);
      if (pixel) this.onPoint(...pixel);
      return;
    }
    const others = [...this.#pointers].filter(([key]) => key !== id).map(([, place]) => place);
    this.#pointers.set(id, at);
    if (others.length > 0) {
      const before = Math.hypot(old[0] - others[0][0], old[1] - others[0][1]);
      const after = Math.hypot(at[0] - others[0][0], at[1] - others[0][1]);
      if (before > 0) this.#zoomTo(this.#zoom.scale * after / before, ...others[0]);
    } else if (!this.#start || Math.hypot(at[0] - this.#start[0], at[1] - this.#start[1]) > 6) {
      this.#start = null;
      this.#pan(at[0] - old[0], at[1] - old[1]);
    }
  }

  #pan(x, y) {
    this.#zoom = { ...this.#zoom, isFitted: false, x: this.#zoom.x + x, y: this.#zoom.y + y };
    this.#draw();
  }

  #key(event) {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const [width, height] = this.#size;
    const step = steps[event.key];
    if (step) {
      const by = event.shiftKey ? 1 : Math.max(1, Math.round(width / 60));
      const [x, y] = this.#cross ?? [width >> 1, height >> 1];
      this.#cross = [Math.min(width - 1, Math.max(0, x + by * step[0])),
                     Math.min(height - 1, Math.max(0, y + by * step[1]))];
      this.onPoint(...this.#cross);
      this.#draw();
    } else if (event.key === "Enter" && this.#cross) {
      this.onPick(...this.#cross);
    } else if (event.key === "+" || event.key === "-") {
      this.magnify(this.#zoom.scale * (event.key === "+" ? 1.25 : 0.8));
    } else {
      return;
    }
    event.preventDefault();
  }

  #draw() {
    if (this.#isDue) return;
    this.#isDue = true;
    requestAnimationFrame(() => {
      this.#isDue = false;
      this.#paint();
    });
  }

  #paint() {
    // A finger on a picture that fits moves the page.
    this.#canvas.style.touchAction = this.#zoom.isFitted ? "pan-y" : "none";
    const context = this.#canvas.getContext("2d");
    const { width, height } = this.#canvas;
    context.clearRect(0, 0, width, height);
    if (!this.#picture) return;
    const [w, h] = this.#size, { scale, x, y } = this.#zoom;
    context.imageSmoothingEnabled = scale < 2 || this.#picture.width < w;
    context.drawImage(this.#picture, x, y, scale * w, scale * h);
    if (this.#other) this.#paintOther(context, x + this.#split * scale * w);
    if (this.#cross) this.#paintCross(context);
  }

  #paintOther(context, edge) {
    const [w, h] = this.#size, { scale, x, y } = this.#zoom;
    context.save();
    context.beginPath();
    context.rect(0, 0, edge, this.#canvas.height);
    context.clip();
    context.drawImage(this.#other, x, y, scale * w, scale * h);
    context.restore();
    context.fillStyle = "#fff";
    context.fillRect(edge - 1, y, 2, scale * h);
  }

  #paintCross(context) {
    const { scale, x, y } = this.#zoom;
    const at = [x + scale * (this.#cross[0] + 0.5), y + scale * (this.#cross[1] + 0.5)];
    for (const [colour, width] of [["#000", 4], ["#f2a33a", 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(at[0] - 12, at[1]);
      context.lineTo(at[0] + 12, at[1]);
      context.moveTo(at[0], at[1] - 12);
      context.lineTo(at[0], at[1] + 12);
      context.stroke();
    }
  }
}
