// Elements of the page.

export function make(kind, attributes = {}, ...children) {
  const element = document.createElement(kind);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

// Shows a value in a box, unless what stands there was refused or is being typed.
export function fill(box, value, row) {
  const isTyped = document.activeElement === box && box.value !== box.dataset.shown;
  if (isTyped || row.classList.contains('is-wrong')) return;
  box.value = value ?? '';
  box.dataset.shown = box.value;
}
