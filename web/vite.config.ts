import { defineConfig, type Plugin } from "vite";

/** The libraries' plain .wasm files stay out of the site: the page unpacks the compressed ones in public/wasm. */
const withoutPlainWasm: Plugin = {
  name: "without-plain-wasm",
  generateBundle(_, bundle) {
    for (const file of Object.keys(bundle)) if (file.endsWith(".wasm")) delete bundle[file];
  },
};

export default defineConfig({
  base: "./",
  plugins: [withoutPlainWasm],
  build: { target: "es2022", chunkSizeWarningLimit: 1500 },
});
