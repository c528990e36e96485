// SPDX-License-Identifier: Apache-2.0
// The part of WASI that the module asks for, over files in memory: nothing leaves the
// page. (WASI preview 1: github.com/WebAssembly/WASI, phases/snapshot.)

const OK = 0, BADF = 8, EXIST = 20, INVAL = 28, NOENT = 44;
const ROOT = 3; // the one folder that is open
const CREATE = 1, EXCLUSIVE = 4, TRUNCATE = 8;
const DIRECTORY_TYPE = 3, FILE_TYPE = 4;

/** A file that grows. */
class MemoryFile {
  constructor(bytes = new Uint8Array(0)) {
    this.bytes = bytes;
    this.size = bytes.length;
  }

  read(offset, into) {
    const part = this.bytes.subarray(Math.min(offset, this.size),
                                     Math.min(offset + into.length, this.size));
    into.set(part);
    return part.length;
  }

  write(offset, from) {
    const end = offset + from.length;
    if (end > this.bytes.length) {
      const grown = new Uint8Array(Math.max(end, 2 * this.bytes.length));
      grown.set(this.bytes);
      this.bytes = grown;
    }
    this.bytes.set(from, offset);
    this.size = Math.max(this.size, end);
  }

  content() {
    return this.bytes.slice(0, this.size);
  }
}

/** Files in memory and the functions by which the module reaches them. */
export class MemoryFiles {
  #files = new Map();
  #open = new Map();
  #nextNumber = ROOT + 1;
  #memory = null;

  put(name, bytes) {
    this.#files.set(name, new MemoryFile(bytes));
  }

  /** A copy of what was written, or undefined. */
  get(name) {
    return this.#files.get(name)?.content();
  }

  remove(name) {
    this.#files.delete(name);
  }

  attach(memory) {
    this.#memory = memory;
  }

  get #view() {
    return new DataView(this.#memory.buffer);
  }

  #name(pointer, length) {
    const bytes = new Uint8Array(this.#memory.buffer).slice(pointer, pointer + length);
    return new TextDecoder().decode(bytes).replace(/^\/+/, "");
  }

  /** Calls step(buffer) for each of the module's buffers until one is not filled. */
  #gather(list, n, result, step) {
    let total = 0;
    for (let i = 0; i < n; i++) {
      const at = this.#view.getUint32(list + 8 * i, true);
      const length = this.#view.getUint32(list + 8 * i + 4, true);
      const done = step(new Uint8Array(this.#memory.buffer, at, length), total);
      total += done;
      if (done < length) break;
    }
    this.#view.setUint32(result, total, true);
    return OK;
  }

  #stat(buffer, number, type, size) {
    const view = this.#view;
    for (let i = 0; i < 64; i += 8) view.setBigUint64(buffer + i, 0n, true);
    view.setBigUint64(buffer + 8, BigInt(number), true);
    view.setUint8(buffer + 16, type);
    view.setBigUint64(buffer + 24, 1n, true);
    view.setBigUint64(buffer + 32, BigInt(size), true);
    return OK;
  }

  #pathOpen(pointer, length, flags, result) {
    const name = this.#name(pointer, length);
    let file = this.#files.get(name);
    if (file && flags & EXCLUSIVE) return EXIST;
    if (!file && !(flags & CREATE)) return NOENT;
    if (!file || flags & TRUNCATE) {
      file = new MemoryFile();
      this.#files.set(name, file);
    }
    const number = this.#nextNumber++;
    this.#open.set(number, { file, place: 0 });
    this.#view.setUint32(result, number, true);
    return OK;
  }

  #seek(fd, offset, whence, result) {
    const open = this.#open.get(fd);
    if (!open) return BADF;
    const from = [0, open.place, open.file.size][whence];
    if (from === undefined || from + Number(offset) < 0) return INVAL;
    open.place = from + Number(offset);
    this.#view.setBigUint64(result, BigInt(open.place), true);
    return OK;
  }

  /** Runs step(open file), or says that there is none. */
  #with(fd, step) {
    const open = this.#open.get(fd);
    return open ? step(open) : BADF;
  }

  get imports() {
    return {
      environ_get: () => OK,
      environ_sizes_get: (count, size) => {
        this.#view.setUint32(count, 0, true);
        this.#view.setUint32(size, 0, true);
        return OK;
      },
      proc_exit: (code) => {
        throw new Error(`the module ended with ${code}`);
      },
      clock_time_get: (clock, precision, result) => {
        this.#view.setBigUint64(result, BigInt(Math.round(performance.now() * 1e6)), true);
        return OK;
      },
      fd_prestat_get: (fd, result) => {
        if (fd !== ROOT) return BADF;
        this.#view.setUint32(result, 0, true);
        this.#view.setUint32(result + 4, 1, true);
        return OK;
      },
      fd_prestat_dir_name: (fd, pointer) => {
        this.#view.setUint8(pointer, "/".charCodeAt(0));
        return OK;
      },
      fd_fdstat_get: (fd, result) => {
        for (let i = 0; i < 24; i += 8) this.#view.setBigUint64(result + i, 0n, true);
        this.#view.setUint8(result, fd === ROOT ? DIRECTORY_TYPE : FILE_TYPE);
        this.#view.setBigUint64(result + 8, 0xffffffffffffffffn, true);
        this.#view.setBigUint64(result + 16, 0xffffffffffffffffn, true);
        return fd <= ROOT || this.#open.has(fd) ? OK : BADF;
      },
      fd_fdstat_set_flags: (fd) => this.#with(fd, () => OK),
      fd_filestat_get: (fd, result) =>
        this.#with(fd, ({ file }) => this.#stat(result, fd, FILE_TYPE, file.size)),
      path_filestat_get: (fd, flags, pointer, length, result) => {
        const name = this.#name(pointer, length);
        if (name === "" || name === ".") return this.#stat(result, ROOT, DIRECTORY_TYPE, 0);
        const file = this.#files.get(name);
        return file ? this.#stat(result, 0, FILE_TYPE, file.size) : NOENT;
      },
      path_open: (fd, lookup, pointer, length, flags, rights, inherited, mode, result) =>
        this.#pathOpen(pointer, length, flags, result),
      path_rename: (fd, from, fromLength, toFd, to, toLength) => {
        const file = this.#files.get(this.#name(from, fromLength));
        if (!file) return NOENT;
        this.#files.delete(this.#name(from, fromLength));
        this.#files.set(this.#name(to, toLength), file);
        return OK;
      },
      path_unlink_file: (fd, pointer, length) =>
        this.#files.delete(this.#name(pointer, length)) ? OK : NOENT,
      fd_close: (fd) => (this.#open.delete(fd) ? OK : BADF),
      fd_seek: (fd, offset, whence, result) => this.#seek(fd, offset, whence, result),
      fd_pread: (fd, list, n, offset, result) =>
        this.#with(fd, ({ file }) =>
          this.#gather(list, n, result, (part, done) => file.read(Number(offset) + done, part))),
      fd_pwrite: (fd, list, n, offset, result) =>
        this.#with(fd, ({ file }) =>
          this.#gather(list, n, result, (part, done) => {
            file.write(Number(offset) + done, part);
            return part.length;
          })),
      fd_read: (fd, list, n, result) =>
        this.#with(fd, (open) =>
          this.#gather(list, n, result, (part) => {
            const done = open.file.read(open.place, part);
            open.place += done;
            return done;
          })),
      fd_write: (fd, list, n, result) => {
        if (fd === 1 || fd === 2) return this.#gather(list, n, result, (part) => part.length);
        return this.#with(fd, (open) =>
          this.#gather(list, n, result, (part) => {
            open.file.write(open.place, part);
            open.place += part.length;
            return part.length;
          }));
      },
    };
  }
}
