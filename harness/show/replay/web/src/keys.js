// The keyboard: one list of what keys do, by which they act and are shown.

// Of what a key event is called in the list: ' ' and letters as they are, other keys by their names.
export const nameOf = (event) => (event.key.length === 1 ? event.key.toLowerCase() : event.key);

export class Keys {
  // `groups` is a list of [title, [[keys, shown, text, action], …]]; `keys` are names of keys, an action takes the event.
  constructor(groups, dialog) {
    Object.assign(this, { groups, dialog });
    this.actions = new Map();
    for (const [, entries] of groups) for (const [keys, , , action] of entries) for (const key of keys) this.actions.set(key, action);
    this.list();
    // The closed list's button keeps no key for itself.
    dialog.addEventListener('close', () => document.activeElement?.blur?.());
    addEventListener('keydown', (event) => this.pressed(event));
  }

  pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // What has a use of its own for a key keeps it.
    const own = !this.dialog.open && this.dialog.contains(event.target) ? null : event.target.closest?.('select, input:not([type=range]), button, summary, a');
    if (own && (event.key === ' ' || event.key === 'Enter' || own.matches('select'))) return;
    if (this.dialog.open && event.key !== '?') return;
    const action = this.actions.get(nameOf(event));
    if (!action) return;
    event.preventDefault();
    action(event);
  }

  // All of them, for people.
  list() {
    const host = this.dialog.querySelector('#key-list');
    for (const [title, entries] of this.groups) {
      const section = document.createElement('section');
      section.append(Object.assign(document.createElement('h2'), { textContent: title }));
      const list = document.createElement('dl');
      for (const [, shown, text] of entries) {
        const term = document.createElement('dt');
        shown.forEach((key) => term.append(Object.assign(document.createElement('kbd'), { textContent: key })));
        list.append(term, Object.assign(document.createElement('dd'), { textContent: text }));
      }
      section.append(list);
      host.append(section);
    }
  }

  toggle() {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }
}
