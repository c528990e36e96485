#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Packs @rackfocus/core for npm.

Usage: package.py FOLDER_OF_WASM FOLDER

Writes rackfocus-core-VERSION.tgz into FOLDER, as `npm pack` does; the same sources give
the same bytes.
"""

import gzip
import io
import json
import pathlib
import re
import sys
import tarfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
OPENEXR = ROOT / "subprojects" / "openexr"

TYPES_HEAD = """\
// SPDX-License-Identifier: Apache-2.0
// Made by web/package.py of the core's table of parameters.

/** The parameters, as on the command line. */
export interface Params {
"""
TYPES_TAIL = """}

/** A row of the table of parameters. */
export interface Parameter {
  name: keyof Params;
  key: string;
  type: "float" | "int" | "bool" | "enum";
  unit: string;
  group: string;
  help: string;
  choices: string[];
  min: number;
  max: number;
  default: number | boolean | string;
}

/** Scene-linear pixels, row by row from the top; alpha premultiplied. */
export interface Image {
  data: Float32Array;
  width: number;
  height: number;
  channels: 1 | 3 | 4;
}

/** A pinhole view from a point of the lens. */
export interface View {
  colour: Image;
  depth: Float32Array;
  /** Scene units right and up. */
  lensOffset?: [number, number];
  /** Distance of the plane that the view's shear keeps fixed; 0: parallel cameras. */
  shearDistance?: number;
}

export const version: string;
export const parameters: readonly Parameter[];

/** A lens and a way to blur with it. */
export class Filter {
  /** Throws a RangeError for what is misspelt or out of range. */
  constructor(params?: Params);
  apply(colour: Image, depth: Float32Array): Image;
  apply(views: View[]): Image;
  /** Signed radii of the circles of confusion, px: positive behind the focus. */
  coc(depth: Float32Array, width: number, height: number): Float32Array;
  /** Why a parameter has no effect with these; null: it has. */
  whyNotRead(name: keyof Params): string | null;
  free(): void;
}
"""
DOCUMENT_TYPES = """\
// SPDX-License-Identifier: Apache-2.0
import type { Image, Parameter, Params } from "./index.js";

export const SHOW: Readonly<
  Record<"picture" | "pinhole" | "depth" | "coc" | "inFocus", number>>;

/** 8 bit, for a canvas. */
export interface Shown {
  rgba: Uint8ClampedArray;
  width: number;
  height: number;
}

/** EXR files with the lens that their headers name. */
export class Document {
  static open(files: { name: string; bytes: Uint8Array }[],
              how?: { threads?: number }): Promise<Document>;
  readonly threads: number;
  readonly memoryBytes: number;
  readonly width: number;
  readonly height: number;
  readonly views: number;
  readonly nearest: number;
  readonly farthest: number;
  readonly remark: string;
  readonly parameters: readonly Parameter[];
  onProgress: (fraction: number) => boolean;
  /** Sets these and no others: the header gives the rest. */
  set(params: Params): void;
  describe(): { name: string; value: string; origin: string; whyUnused: string | null }[];
  distanceAt(x: number, y: number): number;
  radiusAt(x: number, y: number): number;
  render(how?: { best?: boolean; times?: number }): void;
  show(what?: number, exposure?: number): Shown;
  showFile(name: string, bytes: Uint8Array, exposure?: number): Shown;
  pixels(): Image;
  png(): Promise<Uint8Array>;
  exr(): Uint8Array;
  close(): void;
}
"""


def camel(name):
    return re.sub(r"_(.)", lambda m: m[1].upper(), name)


def types():
    """index.d.ts, out of the keywords that the Python package has."""
    text = (ROOT / "plugin" / "rackfocus" / "_params.py").read_text()
    body = text.partition("class Parameters(")[2].partition("class ")[0]
    rows = re.findall(
        r"^    (\w+): (float|int|bool|Literal\[.*?\])$", body, re.M | re.S
    )
    lines = []
    for name, kind in rows:
        choices = re.findall(r'"([^"]*)"', kind)
        simple = {"float": "number", "int": "number", "bool": "boolean"}.get(kind)
        made = simple or " | ".join(f'"{choice}"' for choice in choices)
        lines.append(f"  {camel(name)}?: {made};\n")
    return TYPES_HEAD + "".join(lines) + TYPES_TAIL


def contents(wasm):
    files = {path.name: path.read_bytes() for path in (HERE / "core").iterdir()}
    files = {name: text for name, text in files.items() if not name.endswith(".wasm")}
    package = json.loads(files["package.json"])
    package["version"] = re.search(
        r"version: '([^']+)'", (ROOT / "meson.build").read_text()
    )[1]
    files["package.json"] = (json.dumps(package, indent=2) + "\n").encode()
    files["index.d.ts"] = types().encode()
    files["document.d.ts"] = DOCUMENT_TYPES.encode()
    files |= {path.name: path.read_bytes() for path in wasm.glob("*.wasm")}
    licences = sorted((ROOT / "LICENSES").glob("Apache*")) + [
        OPENEXR / "LICENSE.md",
        OPENEXR / "external" / "deflate" / "COPYING",
    ]
    files["LICENSES.txt"] = b"\n\n".join(path.read_bytes() for path in licences)
    return package["version"], files


def main():
    wasm, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    version, files = contents(wasm)
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for name in sorted(files):
            entry = tarfile.TarInfo(f"package/{name}")
            entry.size = len(files[name])
            archive.addfile(entry, io.BytesIO(files[name]))
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"rackfocus-core-{version}.tgz"
    target.write_bytes(gzip.compress(packed.getvalue(), mtime=0))
    print(f"built: {target}")


if __name__ == "__main__":
    main()
