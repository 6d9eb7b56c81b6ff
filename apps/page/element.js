'use strict';

// Elements and text. Names, reasons and the like come from outside: they enter as text and as
// attribute values, never as markup.

const SVG_TAGS = new Set(['svg', 'g', 'path', 'polygon', 'polyline', 'line', 'rect', 'circle', 'text', 'title']);

// An element; attributes that are functions become listeners, null ones are left out.
function el(tag, attributes = {}, ...children) {
  const element = SVG_TAGS.has(tag)
    ? document.createElementNS('http://www.w3.org/2000/svg', tag)
    : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name, value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value);
  }
  element.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined));
  return element;
}

// A number with so many decimals; a dash where there is none.
function fixed(value, decimals = 2) {
  return Number.isFinite(value) ? value.toFixed(decimals) : '–';
}

function percent(share) {
  return Number.isFinite(share) ? `${Math.round(100 * share)} %` : '–';
}

function point(p, decimals = 2) {
  return `(${p.map(value => fixed(value, decimals)).join(', ')})`;
}

function plural(count, one, many = `${one}s`) {
  return `${count} ${count === 1 ? one : many}`;
}

// "a", "a and b", "a, b and c".
function listed(words) {
  return words.length < 2 ? words.join('') : `${words.slice(0, -1).join(', ')} and ${words.at(-1)}`;
}

// A table. Columns are {head, of: row => text or element, class}.
function table(caption, columns, rows) {
  return el('table', {},
    caption ? el('caption', {}, caption) : null,
    el('thead', {}, el('tr', {}, columns.map(c => el('th', {scope: 'col', class: c.class}, c.head)))),
    el('tbody', {}, rows.map(row => el('tr', {},
      columns.map(c => el('td', {class: typeof c.mark === 'function' ? `${c.class} ${c.mark(row)}` : c.class}, c.of(row)))))));
}

// Something folded away. Whether it is open outlives a redrawing of the page.
const unfolded = new Set();
function folded(key, summary, attributes, ...children) {
  return el('details', {
    ...attributes, 'data-key': key, open: unfolded.has(key) ? '' : null,
    toggle: event => unfolded[event.target.open ? 'add' : 'delete'](key),
  }, el('summary', {'data-key': `${key} summary`}, summary), ...children);
}
