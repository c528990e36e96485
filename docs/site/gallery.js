// SPDX-License-Identifier: Apache-2.0
// Two pictures, one over the other: the slider says where the second begins.

for (const input of document.querySelectorAll(".pair input"))
  input.oninput = () => input.parentElement.style.setProperty("--at", `${input.value}%`);
