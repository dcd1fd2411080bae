// Timers of a hidden page are slowed down, those of its worker are not: so the sign of life is timed here.
setInterval(() => postMessage("alive"), 1000);

export {};
