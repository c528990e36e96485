// SPDX-License-Identifier: Apache-2.0
// Opens files and filters them off the page's thread. There are two of these, one for
// pictures while something is dragged and one for the best, each with files of its own.

import { Document, SHOW } from "./core/document.js";

/** What a preview may take; larger pictures are made smaller for it. */
const PREVIEW_MS = 60;

let picture = null;
let times = 1;

function describe() {
  return {
    width: picture.width, height: picture.height, views: picture.views,
    nearest: picture.nearest, farthest: picture.farthest, remark: picture.remark,
    threads: picture.threads, table: picture.parameters, values: picture.describe(),
  };
}

async function open({ files }) {
  picture?.close();
  picture = null;
  times = 1;
  picture = await Document.open(files);
  return describe();
}

function renderPreview() {
  const start = performance.now();
  picture.render({ best: false, times });
  const ms = performance.now() - start;
  if (ms > PREVIEW_MS && times < 8) times++;
  else if (ms < PREVIEW_MS / 4 && times > 1) times--;
}

function render({ params, best, show, exposure }) {
  const start = performance.now();
  picture.set(params);
  if (show === "picture" && best) {
    picture.onProgress = (fraction) => {
      postMessage({ progress: fraction });
      return true;
    };
    picture.render();
  } else if (show === "picture") {
    renderPreview();
  }
  const image = picture.show(SHOW[show], exposure);
  return { image, best, ms: performance.now() - start, values: picture.describe() };
}

const answers = {
  open,
  render,
  probe: ({ x, y }) => ({ distance: picture.distanceAt(x, y), radius: picture.radiusAt(x, y) }),
  pinhole: ({ exposure }) => ({ image: picture.show(SHOW.pinhole, exposure) }),
  other: ({ file, exposure }) => ({ image: picture.showFile(file.name, file.bytes, exposure) }),
  save: async ({ params, kind }) => {
    picture.set(params);
    return { bytes: kind === "png" ? await picture.png() : picture.exr() };
  },
};

// One after the other: an answer may wait for the browser.
let last = Promise.resolve();

onmessage = ({ data }) => {
  last = last.then(async () => {
    try {
      if (!picture && data.type !== "open") throw new Error("no picture is open");
      const answer = await answers[data.type](data);
      postMessage({ id: data.id, ...answer });
    } catch (error) {
      postMessage({ id: data.id, error: error.message });
    }
  });
};
