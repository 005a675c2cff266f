"use strict"
// The map or diagram of a page: painted, described, chosen from. It knows the numbers of every cell
// (`lanes`: a row for each start of each cell; `cells`: one for each cell) and the Bokeh models by
// name; where they come from, a server or the page itself, is the business of what calls `level`.
const NV = (() => {
  const at = {meta: null, lanes: {}, cells: {}, points: null, show: null, start: 0, cell: [0, 0]}
  const listeners = {chosen: () => {}, shown: () => {}}
  const el = (id) => document.getElementById(id)
  const model = (name) => Bokeh.documents[0].get_model_by_name(name)
  const put = (m, values) => m.setv(values, {sync: false}) // seen here alone: no server is told
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()

  // ---- axes: values, places (values, or numbers 0, 1, 2 ... where they are not evenly spaced)

  function axis(entry) {
    const values = entry.values, n = values.length
    const step = n > 1 ? (values[n - 1] - values[0]) / (n - 1) : Math.abs(values[0]) || 1
    const even = values.every((v, i) => Math.abs(v - values[0] - i * step) <= 1e-6 * Math.abs(step) * n)
    const places = even ? values : values.map((_, i) => i)
    const size = even ? step : 1
    const low = places[0] - size / 2, high = places[n - 1] + size / 2
    return {...entry, n, even, places, step: size, low, high}
  }
  function nearest(a, place) {
    if (a.even) return Math.min(a.n - 1, Math.max(0, Math.round((place - a.places[0]) / a.step)))
    return Math.min(a.n - 1, Math.max(0, Math.round(place)))
  }
  function valueAt(a, place) { // also between cells, and beyond the ends
    if (a.even || a.n < 2) return place
    const i = Math.min(a.n - 2, Math.max(0, Math.floor(place)))
    return a.values[i] + (place - i) * (a.values[i + 1] - a.values[i])
  }
  const named = (a) => a.unit ? `${a.symbol} [${a.unit}]` : a.symbol
  const isMap = () => at.meta.axes.length > 1
  const row = (i, j, k) => ((i * (isMap() ? at.meta.axes[1].n : 1)) + j) * at.meta.starts.length + k
  const cellRow = (i, j) => i * (isMap() ? at.meta.axes[1].n : 1) + j

  // ---- numbers in words

  function digits(value, count = 5) {
    if (value === undefined || Number.isNaN(value)) return ""
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞"
    const size = Math.abs(value)
    const text = size !== 0 && (size < 1e-3 || size >= 1e6)
      ? value.toExponential(count - 2).replace(/\.?0+e/, "e").replace("e+", "e")
      : String(Number(value.toPrecision(count)))
    return text.replace("-", "−")
  }
  function placed(i, j) {
    return at.meta.axes.map((a, d) =>
      `${a.symbol} = ${digits(a.values[d ? j : i], 6)}${a.unit ? " " + a.unit : ""}`).join(", ")
  }
  function labelOf(i, j, k) {
    const codes = at.lanes.label
    return codes ? at.meta.labels[codes[row(i, j, k)]] : ""
  }
  function evidence(i, j, k) {
    const r = row(i, j, k), found = []
    for (const [name, words, unit, width] of at.meta.told) { // what the archive's table says
      const column = at.lanes[name]
      if (!column || !Number.isFinite(column[r])) continue
      let text = digits(column[r], 4)
      const half = width && at.lanes[width] ? at.lanes[width][r] : 0
      if (half > 0) text += ` ± ${digits(half, 2)}`
      found.push([words, unit !== "1" ? `${text} ${unit}` : text])
    }
    const status = at.meta.status[at.lanes.status[r]]
    if (status !== undefined && status !== "ok") found.push(["status", status])
    return found
  }
  function others(i, j) { // what the starts of a cell ended in, by number
    const count = new Map()
    at.meta.starts.forEach((_, k) => {
      const label = labelOf(i, j, k)
      count.set(label, (count.get(label) || 0) + 1)
    })
    return [...count].sort((a, b) => b[1] - a[1]).map(([label, n]) => `${label} × ${n}`).join(", ")
  }
  function shownValue(i, j) {
    const show = at.show
    if (!show || show.points || show.column === "label") return ""
    const column = at.lanes[show.column] || at.cells[show.column]
    if (!column) return ""
    const v = column[show.of_start ? row(i, j, at.start) : cellRow(i, j)]
    if (show.classes.length) return show.column === "most" ? "" : `${show.title}: ${show.classes[v][0]}`
    return Number.isNaN(v) ? "" : `${show.title}: ${digits(v)}${show.unit === "1" ? "" : " " + show.unit}`
  }

  // ---- painting

  function pixel(hex) { // #rrggbb or #rrggbbaa as ABGR
    const n = (i) => parseInt(hex.slice(i, i + 2), 16)
    const alpha = hex.length > 7 ? n(7) : 255
    return ((alpha << 24) | (n(5) << 16) | (n(3) << 8) | n(1)) >>> 0
  }
  function scale(column, logarithmic) {
    let low = Infinity, high = -Infinity
    for (const v of column) if (Number.isFinite(v) && (!logarithmic || v > 0)) {
      if (v < low) low = v
      if (v > high) high = v
    }
    if (!(low <= high)) [low, high] = [0, 1]
    return {low, high, logarithmic}
  }
  function share(v, s) {
    if (s.low === s.high) return 0
    if (s.logarithmic) return Math.log(Math.max(v, s.low) / s.low) / Math.log(s.high / s.low)
    return (v - s.low) / (s.high - s.low)
  }
  const hatchOf = (word) => word === at.meta.hatched
  function pixelsOf(show) { // a function of the row: the color of its cell
    const column = at.lanes[show.column] || at.cells[show.column]
    if (show.classes.length) {
      const shades = show.classes.map(([, c]) => pixel(c))
      return {at: (r) => shades[column[r]]}
    }
    const isShare = show.name.startsWith("share:")
    const s = isShare ? {low: 0, high: 1, logarithmic: false} : scale(column, show.logarithmic)
    const ramp = at.meta.ramp.map(pixel), none = pixel(at.meta.novalue)
    return {scale: s, at: (r) => {
      const v = column[r]
      if (!Number.isFinite(v) || (s.logarithmic && v < 0)) return none
      return ramp[Math.min(255, Math.max(0, Math.floor(256 * share(v, s))))]
    }}
  }
  function putImage(source, pixels, width, height, box) {
    const old = source.data.image[0]
    const image = new old.constructor(pixels, [height, width])
    put(source, {data: {image: [image], x: [box[0]], y: [box[2]], dw: [box[1] - box[0]], dh: [box[3] - box[2]]}})
  }
  function paintMap() {
    const [a, b] = at.meta.axes, found = pixelsOf(at.show)
    const pixels = new Uint32Array(a.n * b.n)
    for (let i = 0; i < a.n; i++)
      for (let j = 0; j < b.n; j++)
        pixels[j * a.n + i] = found.at(at.show.of_start ? row(i, j, at.start) : cellRow(i, j))
    putImage(model("picture"), pixels, a.n, b.n, [a.low, a.high, b.low, b.high])
    legend(found.scale)
  }
  function startColor(k) {
    const c = at.meta.start_colors[k]
    return c === at.meta.ink ? color("ink") : c
  }
  function paintDiagram() { // dots as pixels of what is seen, so that they stay fine in any zoom
    const fig = model("map"), [a] = at.meta.axes, show = at.show
    const x0 = fig.x_range.start, x1 = fig.x_range.end, y0 = fig.y_range.start, y1 = fig.y_range.end
    const W = Math.max(200, Math.round(fig.inner_width || 700)), H = Math.max(120, Math.round(fig.inner_height || 300))
    const pixels = new Uint32Array(W * H), size = !show.points ? 3 : a.n < W / 1.5 ? 2 : 1, S = at.meta.starts.length
    const column = show.points ? at.points[show.column.slice(8)] : at.lanes[show.column]
    const per = show.points ? column.length / (a.n * S) : 1
    for (let k = 0; k < S; k++) {
      const ink = pixel(startColor(k))
      for (let i = 0; i < a.n; i++) {
        const px = Math.round((a.places[i] - x0) / (x1 - x0) * (W - 1))
        if (px < 0 || px >= W) continue
        for (let p = (i * S + k) * per, end = p + per; p < end; p++) {
          const py = Math.round((column[p] - y0) / (y1 - y0) * (H - 1))
          if (!(py >= 0 && py < H)) continue
          for (let dx = 0; dx < size; dx++) for (let dy = 0; dy < size; dy++) {
            const u = px + dx - (size >> 1), v = py + dy - (size >> 1)
            if (u >= 0 && u < W && v >= 0 && v < H) pixels[v * W + u] = ink
          }
        }
      }
    }
    putImage(model("picture"), pixels, W, H, [x0, x1, y0, y1])
    paintStrip(x0, x1)
    legend(null)
  }
  function paintStrip(x0, x1) { // the regimes along the axis, a row for each start
    const strip = model("strip")
    if (!strip || !at.lanes.label) return
    const [a] = at.meta.axes, S = at.meta.starts.length, W = 1400
    const shades = at.meta.classes.map(([, c]) => pixel(c)), pixels = new Uint32Array(W * S)
    for (let u = 0; u < W; u++) {
      const place = x0 + (u + 0.5) / W * (x1 - x0)
      if (place < a.low || place > a.high) continue
      const i = nearestOf(a, place)
      for (let k = 0; k < S; k++) pixels[(S - 1 - k) * W + u] = shades[at.lanes.label[i * S + k]]
    }
    putImage(model("regimes"), pixels, W, S, [x0, x1, 0, 1])
  }
  const nearestOf = nearest
  function paint() {
    if (!at.meta || !at.show) return
    isMap() ? paintMap() : paintDiagram()
  }
  let painting = false
  function paintSoon() {
    if (painting) return
    painting = true
    requestAnimationFrame(() => { painting = false; paint() })
  }

  // ---- legend

  const MOST_NAMED = 40 // classes in a legend: the most frequent; regimes of one color are one

  function entry(list, shade, text, hatched = false) {
    const item = document.createElement("li"), chip = document.createElement("span")
    chip.className = hatched ? "chip hatched" : "chip"
    chip.style.backgroundColor = shade
    item.append(chip, text)
    list.append(item)
  }
  function legend(s) {
    const list = el("legend"), show = at.show
    list.replaceChildren()
    if (!isMap() && at.meta.starts.length > 1)
      at.meta.starts.slice(0, MOST_NAMED).forEach((name, k) => entry(list, startColor(k), name))
    const counted = isMap() ? show : {classes: at.meta.classes, column: "label", of_start: true}
    if (counted.classes && counted.classes.length) {
      const column = at.lanes[counted.column] || at.cells[counted.column]
      if (!column) return
      const count = new Map()
      const S = at.meta.starts.length, every = at.lanes[counted.column] ? S : 1
      for (let r = every > 1 ? at.start : 0; r < column.length; r += every)
        count.set(column[r], (count.get(column[r]) || 0) + 1)
      const total = column.length / every, groups = new Map()
      counted.classes.forEach(([word, shade, group], code) => {
        if (!count.has(code)) return
        const key = group || word, known = groups.get(key)
        if (known) { known.count += count.get(code); known.word = key }
        else groups.set(key, {word, shade, count: count.get(code)})
      })
      const order = [...groups.values()].map((g) => g.count).sort((a, b) => b - a)
      const least = order[Math.min(MOST_NAMED, order.length) - 1]
      const named = [...groups.values()].filter((g) => g.count >= least)
      for (const {word, shade, count: n} of named) {
        const share = n / total
        entry(list, shade, `${word}  ${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`, hatchOf(word))
      }
      if (groups.size > named.length) {
        const item = document.createElement("li")
        item.textContent = `and ${groups.size - named.length} more`
        list.append(item)
      }
    } else if (s) {
      const bar = document.createElement("span"), item = document.createElement("li")
      bar.className = "chip ramp"
      bar.style.background = `linear-gradient(90deg, ${at.meta.ramp.filter((_, i) => i % 15 === 0).join(",")})`
      bar.style.width = "220px"
      const unit = show.unit === "1" ? "" : ` ${show.unit}`
      const isShare = show.name.startsWith("share:")
      const text = (v) => isShare ? `${Math.round(100 * v)} %` : digits(v, 4) + unit
      item.append(`${text(s.low)}  `, bar, ` ${text(s.high)}${s.logarithmic ? ", logarithmic" : ""}`)
      list.append(item)
    }
  }

  // ---- choosing a cell

  function mark() {
    const [i, j] = at.cell, [a, b] = at.meta.axes
    const x = a.places[i], y = isMap() ? b.places[j] : NaN
    put(model("mark"), {data: {x: [x], y: [y]}})
    put(model("cross x"), {location: x})
    if (isMap()) put(model("cross y"), {location: y})
    const words = [placed(i, j), labelOf(i, j, at.start), shownValue(i, j)].filter((t) => t)
    el("readout").textContent = words.join("  ·  ")
  }
  function choose(i, j, start = at.start) {
    at.cell = [i, j]
    at.start = start
    el("start").value = String(start)
    mark()
    listeners.chosen(i, j, start)
  }
  const KEYS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}
  function key(event) {
    if (!at.meta || event.ctrlKey || event.metaKey || event.altKey) return
    if (event.target.closest && event.target.closest("input, select, textarea, summary")) return
    const step = KEYS[event.key]
    if (!step) return
    event.preventDefault()
    const far = event.shiftKey ? 10 : 1, [a, b] = at.meta.axes
    const clip = (v, n) => Math.min(n - 1, Math.max(0, v))
    choose(clip(at.cell[0] + far * step[0], a.n), isMap() ? clip(at.cell[1] + far * step[1], b.n) : 0)
  }
  function cellAt(x, y) {
    const [a, b] = at.meta.axes
    if (x < a.low || x > a.high) return null
    if (isMap() && (y < b.low || y > b.high)) return null
    return [nearest(a, x), isMap() ? nearest(b, y) : 0]
  }
  function tap(x, y) {
    const cell = at.meta && cellAt(x, y)
    if (cell) choose(...cell)
  }

  // ---- hovering

  const pointer = {x: 0, y: 0}
  document.addEventListener("pointermove", (e) => { pointer.x = e.clientX; pointer.y = e.clientY })
  function hover(x, y) {
    const tip = el("tip"), cell = at.meta && cellAt(x, y)
    tip.hidden = !cell
    if (!cell) return
    const lines = [placed(...cell)], several = at.meta.starts.length > 1
    const value = shownValue(...cell)
    if (value) lines.push(value)
    if (several && at.lanes.label) lines.push(`${at.meta.starts.length} starts: ${others(...cell)}`)
    const rows = evidence(...cell, at.start).slice(0, 7).map(([t, v]) => `${t}: ${v}`)
    const head = document.createElement("b")
    head.textContent = labelOf(...cell, at.start) + (several ? ` (${at.meta.starts[at.start]})` : "")
    tip.replaceChildren(head, ...[...lines, ...rows].map((text) => {
      const line = document.createElement("div")
      line.textContent = text
      return line
    }))
    const box = tip.getBoundingClientRect()
    const left = pointer.x + 16 + box.width > innerWidth ? pointer.x - box.width - 12 : pointer.x + 16
    const top = Math.min(pointer.y + 12, innerHeight - box.height - 8)
    tip.style.left = `${left}px`
    tip.style.top = `${top}px`
  }
  const leave = () => { el("tip").hidden = true }

  // ---- levels: a map, or a part of it computed finer

  function options(select, entries, value) {
    select.replaceChildren(...entries.map(([name, title]) => new Option(title, name, false, name === value)))
    select.value = value
  }
  function level(meta, lanes, cells, points) {
    const before = at.show && at.show.name
    leave()
    keepBeneath(meta)
    Object.assign(at, {meta: {...meta, axes: meta.axes.map(axis)}, lanes, cells, points})
    at.start = Math.min(at.start, meta.starts.length - 1)
    at.cell = meta.cell || at.cell
    at.show = meta.shows.find((s) => s.name === before) || meta.shows[0]
    options(el("show"), meta.shows.map((s) => [s.name, s.title]), at.show.name)
    options(el("start"), meta.starts.map((name, k) => [String(k), name]), String(at.start))
    el("starts").hidden = meta.starts.length < 2
    const fig = model("map"), [a, b] = at.meta.axes
    for (const f of [fig, model("strip")].filter((f) => f)) span(f.x_range, a.low, a.high)
    put(fig.below[0], {axis_label: `${a.meaning}, ${named(a)}`})
    ticks(fig.below[0], a)
    if (isMap()) {
      span(fig.y_range, b.low, b.high)
      put(fig.left[0], {axis_label: `${b.meaning}, ${named(b)}`})
      ticks(fig.left[0], b)
    } else fitValues()
    const [ci, cj] = at.cell
    at.cell = [Math.min(ci, a.n - 1), isMap() ? Math.min(cj, b.n - 1) : 0]
    paint()
    mark()
    el("text").textContent = alternative()
  }
  function keepBeneath(meta) { // of a part that is to be computed finer, the cells seen so far
    const beneath = model("beneath"), old = at.meta && at.meta.axes
    if (!beneath || !old) return
    const part = meta.axes.map(axis).map((a, d) => [a, old[d]])
    const within = part.every(([a, b]) => a.even && b.even && a.low >= b.low - b.step && a.high <= b.high + b.step)
    const same = part.every(([a, b]) => a.low === b.low && a.high === b.high)
    const empty = {image: [new Uint32Array(1)], x: [0], y: [0], dw: [0], dh: [0]}
    const seen = model("picture").data, size = seen.image[0].constructor
    empty.image = [new size(new Uint32Array(1), [1, 1])]
    put(beneath, {data: within && !same ? {...seen} : empty})
  }
  function refresh(meta, lanes, cells, points) { // the same level, more of it computed
    const before = at.show.name
    Object.assign(at, {meta: {...meta, axes: at.meta.axes}, lanes, cells, points})
    at.show = meta.shows.find((s) => s.name === before) || meta.shows[0]
    options(el("show"), meta.shows.map((s) => [s.name, s.title]), at.show.name)
    if (!isMap()) fitValues()
    paint()
    mark()
    el("text").textContent = alternative()
  }
  function span(range, low, high) { put(range, {start: low, end: high, reset_start: low, reset_end: high}) }
  function ticks(model, a) {
    if (a.even) return
    const every = Math.ceil(a.n / 8), chosen = a.places.filter((i) => i % every === 0)
    const labels = new Map(a.places.map((i) => [i, digits(a.values[i], 4)]))
    put(model, {major_label_overrides: labels, ticker: new Bokeh.Models.get("FixedTicker")({ticks: chosen})})
  }
  function fitValues() { // the range of a diagram's values, of the cells that are seen
    const show = at.show, column = show.points ? at.points[show.column.slice(8)] : at.lanes[show.column]
    const s = scale(column, false), room = 0.04 * (s.high - s.low || Math.abs(s.high) || 1)
    const fig = model("map")
    span(fig.y_range, s.low - room, s.high + room)
    put(fig.left[0], {axis_label: show.unit === "1" ? show.title : `${show.title} [${show.unit}]`})
  }
  function alternative() {
    const m = at.meta, sides = m.axes.map((a) =>
      `${a.meaning} ${a.symbol} from ${digits(a.values[0])} to ${digits(a.values[a.n - 1])} ${a.unit} in ${a.n} steps`)
    const shares = [...el("legend").children].map((li) => li.textContent.trim()).join("; ")
    return `${isMap() ? "Map" : "Diagram"} over ${sides.join(" and ")}. ${at.show.title}: ${shares}.`
  }
  function choosShow(name) {
    at.show = at.meta.shows.find((s) => s.name === name)
    if (!isMap()) fitValues()
    paint()
    mark()
    el("text").textContent = alternative()
    listeners.shown(name)
  }

  // ---- themes

  const ROLES = ["ink", "body", "wall", "blue", "green", "pink", "muted", "text"]
  function paintTheme() {
    const c = Object.fromEntries([...ROLES, "card", "grid", "line"].map((n) => [n, color(n)]))
    for (const fig of Bokeh.documents[0].roots().filter((r) => r.type === "Figure")) {
      put(fig, {background_fill_color: c.card, outline_line_color: c.line})
      for (const side of [...fig.left, ...fig.below, ...fig.right, ...fig.above].filter((m) => m.axis_line_color !== undefined))
        put(side, {axis_line_color: c.line, major_tick_line_color: c.muted, minor_tick_line_color: null,
          major_label_text_color: c.muted, axis_label_text_color: c.text})
      for (const m of fig.center) {
        if (m.type === "Grid") put(m, {grid_line_color: c.grid})
        role(m, c)
      }
      for (const r of fig.renderers) { role(r, c); if (r.glyph) role(r, c, r.glyph) }
    }
    paintSoon()
  }
  function paintNow() { // nothing is printed that is not painted when the event ends
    paint()
    for (const fig of Bokeh.documents[0].roots().filter((r) => r.type === "Figure")) {
      const view = Bokeh.index.find_one_by_id(fig.id)
      if (view) view.paint()
    }
  }
  function role(m, c, target = m) {
    const tag = (m.tags || []).find((t) => ROLES.includes(t))
    if (!tag) return
    for (const name of ["line_color", "fill_color", "text_color"]) {
      const old = target[name]
      if (old === undefined || old === null || old.value === null) continue
      put(target, {[name]: typeof old === "string" ? c[tag] : {value: c[tag]}})
    }
  }
  const darkness = matchMedia("(prefers-color-scheme: dark)")
  let wanted = null // light, dark, or null for what the system asks for
  function theme(name = wanted || (darkness.matches ? "dark" : "light")) {
    document.documentElement.dataset.theme = name
    el("theme").textContent = name === "dark" ? "light" : "dark"
    if (Bokeh.documents.length) paintTheme()
  }
  function calm() { // a figure shows that it has the focus where keys are used, not after a click
    for (const fig of Bokeh.documents[0].roots().filter((r) => r.type === "Figure")) {
      const view = Bokeh.index.find_one_by_id(fig.id), style = document.createElement("style")
      style.textContent = ".bk-events:focus:not(:focus-visible) { outline: none; }"
      if (view && view.canvas_view) view.canvas_view.shadow_el.append(style)
    }
  }
  function startPage() {
    calm()
    theme()
    darkness.addEventListener("change", () => theme())
    addEventListener("beforeprint", () => { theme("light"); paintNow() })
    addEventListener("afterprint", () => theme())
    el("theme").addEventListener("click", () => {
      wanted = document.documentElement.dataset.theme === "dark" ? "light" : "dark"
      theme()
    })
    el("show").addEventListener("change", (e) => choosShow(e.target.value))
    el("start").addEventListener("change", (e) => { at.start = Number(e.target.value); paint(); choose(...at.cell) })
    document.addEventListener("keydown", key)
    for (const range of [model("map").x_range, model("map").y_range])
      for (const name of ["start", "end"])
        range.properties[name].change.connect(() => { if (at.meta && !isMap()) paintSoon() })
  }
  return {at, el, model, color, digits, listeners, level, refresh, choose, tap, hover, leave,
    put, evidence, labelOf, others, placed, row, theme, startPage, valueAt, isMap, nearest}
})()
