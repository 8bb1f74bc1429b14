import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

// Stable file names: the build is committed, and a change of one file must not rename the others.
// `npm run build` (scripts/build.mjs) builds into a folder of its own and puts what is whole where it is served.
export default defineConfig({
  plugins: [react()],
  base: "./",
  build: {
    target: "es2022",
    sourcemap: false,
    rolldownOptions: {
      output: {
        entryFileNames: "assets/[name].js",
        chunkFileNames: "assets/[name].js",
        assetFileNames: "assets/[name][extname]",
        codeSplitting: {
          groups: [
            { name: "text-vendor", test: /node_modules\/(@codemirror|@lezer|@marijn|style-mod|w3c-keyname|crelt)\//, priority: 2 },
            { name: "robot-vendor", test: /node_modules\/three\//, priority: 2 },
            { name: "flow-vendor", test: /node_modules\/elkjs\//, priority: 2 },
            { name: "vendor", test: /node_modules/, priority: 1 },
          ],
        },
      },
    },
  },
});
