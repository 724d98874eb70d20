// The socket of a scene: views up, frames and changes down.

import * as api from "./api.js";
import { BACKOFF_MS, Problem, ServerLost } from "./api.js";

const PROTOCOL = "fogbank.v1";
const GONE = 4404;
// A socket that fails so often while requests are answered is not to be had: a proxy may not know sockets.
const ATTEMPTS = 2;
const AGAIN_MS = 30_000;

/** Keeps a socket open to one scene. */
export class Live {
  #events;
  #socket = null;
  #id = null;
  #isOpen = false;
  #failures = 0;
  #backoff_ms = BACKOFF_MS.first;
  #timer = 0;
  #decoding = Promise.resolve();
  /** Whether the server is surely the one that told what this page knows. */
  #isSame = false;

  /**
   * Events: `hello(message)`, `scene(message)`, `viewers(count)`, `refused(seq, problem)`, `frame(header, blob)`, which is
   * waited for before the frame is acknowledged; `gone()` where the server knows no such scene, `deleted()` where it was just deleted; `lost(retryIn_ms)` while the server is
   * away; `unavailable()` where requests must do; `revision()` answers the revision that the page has, or null.
   */
  constructor(events) {
    this.#events = events;
  }

  get isOpen() {
    return this.#isOpen;
  }

  /** Opens the socket of a scene instead of the one before. */
  open(id) {
    this.#id = id;
    this.#isSame = true;
    this.#reopen();
  }

  /** Sends a message if the socket is open; what is not sent is old when it is. */
  say(message) {
    if (this.#isOpen) this.#socket.send(JSON.stringify(message));
  }

  /** Has the scene told anew. */
  reopen() {
    this.#isSame = false;
    this.#reopen();
  }

  /** Tries again after a while. */
  retry() {
    this.#later(this.#backoff_ms);
    this.#backoff_ms = Math.min(this.#backoff_ms * 2, BACKOFF_MS.most);
  }

  #reopen() {
    clearTimeout(this.#timer);
    this.#isOpen = false;
    if (this.#socket) this.#socket.onclose = this.#socket.onmessage = null;
    this.#socket?.close();
    const socket = new WebSocket(api.liveAddress(this.#id, this.#isSame ? this.#events.revision() : null), PROTOCOL);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.#hear(JSON.parse(data)) : this.#take(data));
    socket.onclose = ({ code }) => this.#closed(code);
    this.#socket = socket;
  }

  #hear(message) {
    switch (message.type) {
      case "hello":
        this.#isOpen = true;
        this.#failures = 0;
        this.#backoff_ms = BACKOFF_MS.first;
        return this.#events.hello(message);
      case "scene": return this.#events.scene(message);
      case "viewers": return this.#events.viewers(message.count);
      case "error": return this.#events.refused(message.seq, new Problem(message.problem.status, message.problem));
    }
  }

  /** Frames are shown in the order in which they came, and acknowledged when they are. */
  #take(data) {
    const length = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const blob = new Blob([new Uint8Array(data, 4 + length)], { type: header.content_type });
    const socket = this.#socket;
    this.#decoding = this.#decoding.then(async () => {
      try {
        if (socket === this.#socket) await this.#events.frame(header, blob);
      } catch (error) {
        // One picture that cannot be shown must not keep the next ones away.
        console.error(error);
      }
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ type: "ack", frame: header.frame }));
    });
  }

  async #closed(code) {
    const [socket, wasOpen] = [this.#socket, this.#isOpen];
    this.#isOpen = false;
    this.#isSame = false;
    if (code === GONE && wasOpen) return this.#events.deleted();
    const state = wasOpen ? "closed" : await this.#look();
    // Another scene may have been opened meanwhile.
    if (socket !== this.#socket) return;
    if (state === "gone") return this.#events.gone();
    if (state === "answers") {
      this.#failures += 1;
      if (this.#failures < ATTEMPTS) return this.retry();
      this.#events.unavailable();
      return this.#later(AGAIN_MS);
    }
    this.#events.lost(this.#backoff_ms);
    this.retry();
  }

  #later(delay_ms) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#reopen(), delay_ms);
  }

  /** A browser does not tell why a socket was refused; a request does. */
  async #look() {
    try {
      await api.history(this.#id);
      return "answers";
    } catch (error) {
      if (error instanceof ServerLost) return "lost";
      return error.status === 404 ? "gone" : "busy";
    }
  }
}
