// SPDX-License-Identifier: Apache-2.0
// The WebAssembly module: loading it, and text and pixels into and out of its memory.

import { MemoryFiles } from "./wasi.js";

const STACK_BYTES = 1 << 20;

/** Threads share memory, which only pages that are isolated from other origins may. */
function countThreads(asked) {
  if (!globalThis.crossOriginIsolated) return 1;
  return Math.max(1, Math.min(asked ?? navigator.hardwareConcurrency, 16));
}

async function compile(name) {
  const address = new URL(name, import.meta.url);
  if (address.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    return WebAssembly.compile(await readFile(address));
  }
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address.pathname}: ${answer.status} ${answer.statusText}`);
  return WebAssembly.compile(await answer.arrayBuffer());
}

/** An instance with memory of its own. */
export class Module {
  #memory;
  #helpers = [];
  /** Called with 0 to 1 while a best picture is made; false cancels. */
  onProgress = () => true;
  files = new MemoryFiles();
  threads = 1;

  /** `threads`: at most so many; as many as the machine has where it is left out. */
  static async load({ threads } = {}) {
    const self = new Module();
    self.threads = countThreads(threads);
    if (self.threads === 1) await self.#start(await compile("./rackfocus.wasm"), {});
    else await self.#startThreads();
    return self;
  }

  async #start(compiled, env) {
    const instance = await WebAssembly.instantiate(compiled, {
      env,
      wasi_snapshot_preview1: this.files.imports,
      rackfocus: { progress: (fraction) => (this.onProgress(fraction) ? 1 : 0) },
    });
    this.exports = instance.exports;
    this.#memory = env.memory ?? instance.exports.memory;
    this.files.attach(this.#memory);
    this.exports._initialize();
  }

  async #startThreads() {
    const compiled = await compile("./rackfocus-threads.wasm");
    const memory = new WebAssembly.Memory({ initial: 128, maximum: 65536, shared: true });
    await this.#start(compiled, { memory });
    const { __tls_size: size, __wasm_init_tls: useVariables } = this.exports;
    const variables = () => this.allocate(size.value + 16) + 15 & ~15;
    useVariables(variables());
    for (let i = 1; i < this.threads; i++) {
      const helper = new Worker(new URL("./helper.js", import.meta.url), { type: "module" });
      helper.postMessage({ compiled, memory, variables: variables(),
                           stack: (this.allocate(STACK_BYTES) & ~15) + STACK_BYTES });
      this.#helpers.push(helper);
    }
  }

  /** Ends its threads; it cannot be used afterwards. */
  end() {
    for (const helper of this.#helpers) helper.terminate();
  }

  get memoryBytes() {
    return this.#memory.buffer.byteLength;
  }

  get #bytes() {
    return new Uint8Array(this.#memory.buffer);
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
    return new Float32Array(this.#memory.buffer, pointer, n);
  }

  doubles(pointer, n) {
    return new Float64Array(this.#memory.buffer, pointer, n);
  }

  bytes(pointer, n) {
    return new Uint8ClampedArray(this.#memory.buffer, pointer, n);
  }

  /** Throws what went wrong where a result says so. */
  check(result) {
    if (result === 0) throw new RangeError(this.text(this.exports.rw_error()));
    return result;
  }
}
