// what a page without a server does: another number or start, a cell in words, its section, keys
const now = () => Number(start.value), near = (at, v) => at.reduce((b, a, i) => Math.abs(a - v) < Math.abs(at[b] - v) ? i : b, 0)
const text = (v, n = 4) => String(Number(v.toPrecision(n))).replaceAll("-", "−"), many = starts > 1
const lane = (i, j) => (i * second.length + j) * starts + now(), clip = (i, n) => Math.min(Math.max(i, 0), n - 1)
const safe = (words) => words.replaceAll("&", "&amp;").replaceAll("<", "&lt;")
const state = (at, p, c) => codes[(at * points + p) * parts + c] === 65535 ? NaN : low[c] + codes[(at * points + p) * parts + c] * step[c]
function paint() {
  const one = shows.find((s) => s.name === show.value), key = one.each ? `${one.name}:${now()}` : one.name
  legend.text = one.legends[one.each ? now() : 0]
  described.text = safe(one.described[one.described.length > 1 ? now() : 0])
  if (dots.length) dots.forEach((source, k) => {
    const x = [], y = [], c = one.component, values = columns.data[one.name]
    for (let i = 0; i < first.length; i++) for (let p = 0; p < (c < 0 ? 1 : points); p++) {
      x.push(first[i])
      y.push(c < 0 ? values[i * starts + k] : state(i * starts + k, p, c))
    }
    source.data = {x, y}
  })
  if (dots.length) { span.setv({start: one.span[0], end: one.span[1]}); ordinate.axis_label = one.label }
  else { mapper.setv({palette: one.palette, low: -0.5, high: one.palette.length - 0.5}); picture.data = {...picture.data, image: images.data[key]} }
  if (!dots.length) hatch.data = one.hatch[one.each ? now() : 0]
  for (const [name, lines] of Object.entries(branches)) for (const line of lines) line.visible = name === "" || name === one.name
}
function number(row, at) { // in words; undefined if there is none
  const [name, title, unit, width] = row, v = columns.data[name]?.[at], half = columns.data[width]?.[at]
  if (Number.isFinite(v)) return `${title}: ${text(v)}${half > 0 ? " ± " + text(half, 2) : ""} ${unit === "1" ? "" : unit}`
}
const place = (i, j) => places[0][i] + (places[1] ? ", " + places[1][j] : "")
function head(at) {
  const label = columns.data.label ? labels[columns.data.label[at]] : ""
  return `<b>${safe(label)}${many ? ` (${safe(names[now()])})` : ""}</b><br>`
}
function tip_of(i, j) { // label, place and one number: the shown one, or else the first
  const at = lane(i, j), shown = numbers.find(([name]) => name === show.value), all = shown ? [shown] : numbers
  const one = all.map((row) => number(row, at)).find((words) => words)
  return head(at) + [place(i, j), ...(one ? [one] : [])].map(safe).join("<br>")
}
function words(i, j) {
  const at = lane(i, j), lines = [place(i, j), ...numbers.map((row) => number(row, at)).filter((words) => words)]
  if (many && columns.data.label) lines.splice(1, 0, "all starts: " + names.map((_, k) => labels[columns.data.label[at - now() + k]]).join(", "))
  return head(at) + lines.map(safe).join("<br>")
}
function choose(i, j) {
  Object.assign(chosen, {i, j})
  lines.forEach((line, d) => { line.location = d ? second[j] : first[i] })
  if (!dots.length) mark.data = {x: [first[i]], y: [second[j]]}
  verdict.text = words(i, j)
  if (!points) return
  const data = {}
  for (let c = 0; c < parts; c++) data[components[c]] = Array.from({length: points}, (_, p) => state(lane(i, j), p, c))
  section.data = data
}
function pointed(x, y) {
  const inside = x >= box[0] && x <= box[1] && (second.length < 2 || y >= box[2] && y <= box[3])
  return inside ? [near(first, x), second.length > 1 ? near(second, y) : 0] : null
}
function hover(event) {
  const cell = pointed(event.x, event.y)
  const side = event.sx > event.origin.inner_width / 2 ? ["tip", "left"] : ["tip"]
  const top = event.sy + 16 - (event.origin === homes.at(-1) ? 0 : event.origin.height)
  if (cell) tip.setv({text: tip_of(...cell), css_classes: side, styles: {left: `${event.sx}px`, top: `${top}px`}})
  tip.visible = !!cell
}
const chosen = {i: first.length >> 1, j: second.length >> 1}
for (const home of homes) {
  home.on_event("tap", (event) => { const cell = pointed(event.x, event.y); if (cell) choose(...cell) })
  home.on_event("mousemove", hover)
  home.on_event("mouseleave", () => { tip.visible = false })
}
show.properties.value.change.connect(paint)
start.properties.value.change.connect(() => { paint(); choose(chosen.i, chosen.j) })
key.properties.text.change.connect(() => {
  const [right, up] = key.text.split(" ").map(Number)
  choose(clip(chosen.i + right, first.length), clip(chosen.j + up, second.length))
})
paint()
choose(chosen.i, chosen.j)
document.documentElement.dataset.ready = "yes"
