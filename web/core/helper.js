// SPDX-License-Identifier: Apache-2.0
// A thread: the same module on the same memory, waiting for loops to share.

onmessage = async ({ data: { compiled, memory, stack, variables } }) => {
  const names = WebAssembly.Module.imports(compiled).filter(({ kind }) => kind === "function");
  const imports = { env: { memory } };
  // Loops call nothing of the page's.
  for (const { module, name } of names) (imports[module] ??= {})[name] = () => 0;
  const { exports } = await WebAssembly.instantiate(compiled, imports);
  exports.__stack_pointer.value = stack;
  exports.__wasm_init_tls(variables);
  exports.rw_help();
};
