import { defineConfig } from 'vite';

// Fixed names: the files become part of the program. `npm run dev` shows the page of a roomfix that runs beside it.
export default defineConfig({
  base: './',
  build: {
    target: 'es2020',
    rollupOptions: { output: { entryFileNames: 'app.js', assetFileNames: 'app.[ext]' } },
  },
  server: { proxy: { '/api': 'http://127.0.0.1:8080' } },
});
