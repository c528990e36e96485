// SPDX-License-Identifier: Apache-2.0
// The WebAssembly module: loading it, and text and pixels into and out of its memory.

import { MemoryFiles } from "./wasi.js";

const WASM = new URL("./rackfocus.wasm", import.meta.url);

async function compile() {
  if (WASM.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    return WebAssembly.compile(await readFile(WASM));
  }
  const answer = await fetch(WASM);
  if (!answer.ok) throw new Error(`${WASM.pathname}: ${answer.status} ${answer.statusText}`);
  return WebAssembly.compile(await answer.arrayBuffer());
}

/** An instance with memory of its own. */
export class Module {
  /** Called with 0 to 1 while a best picture is made; false cancels. */
  onProgress = () => true;
  files = new MemoryFiles();

  static async load() {
    const self = new Module();
    const instance = await WebAssembly.instantiate(await compile(), {
      wasi_snapshot_preview1: self.files.imports,
      rackfocus: { progress: (fraction) => (self.onProgress(fraction) ? 1 : 0) },
    });
    self.exports = instance.exports;
    self.files.attach(instance.exports.memory);
    instance.exports._initialize();
    return self;
  }

  get #bytes() {
    return new Uint8Array(this.exports.memory.buffer);
  }

  /** Memory to be released; RangeError where there is none. */
  allocate(nBytes) {
    const pointer = this.exports.rw_allocate(nBytes);
    if (pointer === 0) throw new RangeError("out of memory");
    return pointer;
  }

  release(...pointers) {
    for (const pointer of pointers) this.exports.rw_release(pointer);
  }

  /** The text at a pointer, or null for none. */
  text(pointer) {
    if (pointer === 0) return null;
    const bytes = this.#bytes;
    return new TextDecoder().decode(bytes.slice(pointer, bytes.indexOf(0, pointer)));
  }

  /** Runs step(pointer of each text). */
  withTexts(texts, step) {
    const pointers = texts.map((text) => {
      const bytes = new TextEncoder().encode(`${text}\0`);
      const pointer = this.allocate(bytes.length);
      this.#bytes.set(bytes, pointer);
      return pointer;
    });
    try {
      return step(...pointers);
    } finally {
      this.release(...pointers);
    }
  }

  /** A view of memory, good until the module is called again. */
  floats(pointer, n) {
    return new Float32Array(this.exports.memory.buffer, pointer, n);
  }

  doubles(pointer, n) {
    return new Float64Array(this.exports.memory.buffer, pointer, n);
  }

  bytes(pointer, n) {
    return new Uint8ClampedArray(this.exports.memory.buffer, pointer, n);
  }

  /** Throws what went wrong where a result says so. */
  check(result) {
    if (result === 0) throw new RangeError(this.text(this.exports.rw_error()));
    return result;
  }
}
