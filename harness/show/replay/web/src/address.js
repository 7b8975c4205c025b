// The page's address: `#t=12.5&run=1&view=top…` says what is seen. It is read when the page is opened, and kept up to date without
// an entry of the history for every step.

const REST = 300; // ms until a change is written
const PLAYING = 1500; // the same while time goes on

export const number = (v, digits = 2) => String(Number(v.toFixed(digits)));

// Names in one value, e.g. `lidar,map`; null if the address doesn't say it.
const names = (asked, name) => (asked.has(name) ? asked.get(name).split(',') : null);

export function read() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const numbers = (name, count) => {
    const found = (asked.get(name) ?? '').split(',').map(Number);
    return asked.has(name) && found.length === count && found.every(Number.isFinite) ? found : null;
  };
  return {
    time: numbers('t', 1)?.[0], run: numbers('run', 1)?.[0], view: asked.get('view'), trail: asked.get('trail'),
    hidden: names(asked, 'hide'), depth: asked.get('depth'), numbers,
  };
}

export class Address {
  // `state` gives names with values, which need no escape.
  constructor(state) {
    this.state = state;
    this.timer = null;
    this.last = null;
  }

  text() {
    return this.state().map(([name, value]) => `${name}=${value}`).join('&');
  }

  // What is seen now needs no address of its own.
  begin() {
    this.last = this.text();
  }

  changed(playing) {
    if (this.last === null || this.timer !== null) return;
    this.timer = setTimeout(() => this.write(), playing ? PLAYING : REST);
  }

  write() {
    this.timer = null;
    const text = this.text();
    if (text === this.last) return;
    this.last = text;
    try {
      history.replaceState(history.state, '', `#${text}`);
    } catch {
      // A browser that allows no more changes for now: the next one comes.
    }
  }
}
