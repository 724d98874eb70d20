// Time: a button that runs the scene's time, picture by picture.

/**
 * While it runs, `tick()` sets the time to what has passed since it was started, at each picture that is shown: a slow server
 * shows fewer moments, not later ones.
 */
export function bindClock(button, shown, { getTime, setTime }) {
  let startedAt_ms = null;
  let from_s = 0;
  const refresh = () => {
    const isRunning = startedAt_ms !== null;
    button.textContent = isRunning ? "Pause" : "Play";
    button.setAttribute("aria-pressed", String(isRunning));
    shown.textContent = `${getTime().toFixed(2)} s`;
  };
  const tick = () => {
    if (startedAt_ms === null) return;
    setTime(from_s + (performance.now() - startedAt_ms) / 1000);
  };
  const pause = () => {
    startedAt_ms = null;
    refresh();
  };
  button.addEventListener("click", () => {
    if (startedAt_ms !== null) return pause();
    from_s = getTime();
    startedAt_ms = performance.now();
    refresh();
    tick();
  });
  refresh();
  return { tick, pause, refresh };
}
