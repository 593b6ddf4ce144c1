// The address of the worker, for src/main.tsx: the build writes it into the page.
export const workerUrl = document.querySelector('meta[name="worker"]').content;
