// How far a slow request is: the server is asked while the answer is on its way.

import * as api from "./api.js";
import { freshName } from "./document.js";
import { button, element } from "./dom.js";

// Whoever waits for less need not be told.
const FIRST_MS = 700;
const EVERY_MS = 400;

/**
 * Asks how far a job is until `signal` says that it ended, and tells `show({state, fraction})`. No answer about it is no
 * news: it may have just come in, or just ended.
 */
export function watch(job, signal, show) {
  const poll = async () => {
    if (signal.aborted) return;
    const progress = await api.progress(job, signal).catch(() => null);
    if (signal.aborted) return;
    if (progress) show(progress);
    setTimeout(poll, EVERY_MS);
  };
  setTimeout(poll, FIRST_MS);
}

/** Runs `ask(job)`, a request that names its job, and tells `show` how far it is. */
export async function followed(ask, show) {
  const job = freshName();
  const controller = new AbortController();
  watch(job, controller.signal, show);
  try {
    return await ask(job);
  } finally {
    controller.abort();
  }
}

/** `{state, fraction}` in words. */
export function progressText(what, { state, fraction }) {
  return state === "waiting" ? `${what} waits for its turn` : `${what}: ${Math.floor(100 * fraction)} %`;
}

/** Binds the box that shows how far the picture is and can stop it; `stop()` and `resume()` do that. */
export function bindProgress(box, { stop, resume }) {
  const text = element("span");
  const bar = element("progress", { max: 1, "aria-label": "Progress of the picture" });
  const stopButton = button("Stop", stop, { className: "small" });
  const resumeButton = button("Render", resume, { className: "small" });
  box.append(text, bar, stopButton, resumeButton);

  function put(words, isStopped) {
    const [shown, other] = isStopped ? [resumeButton, stopButton] : [stopButton, resumeButton];
    const hadFocus = other === document.activeElement;
    text.textContent = words;
    bar.hidden = isStopped;
    shown.hidden = box.hidden = false;
    other.hidden = true;
    if (hadFocus) shown.focus();
  }

  return {
    /** Shows how far the picture of that quality is. */
    show(quality, progress) {
      // A bar without a value says that there is no saying yet.
      if (progress.fraction > 0) bar.value = progress.fraction;
      else bar.removeAttribute("value");
      put(progressText(quality === "draft" ? "Draft" : "Full picture", progress), false);
    },
    stopped: () => put("Stopped.", true),
    hide: () => { box.hidden = true; },
  };
}
