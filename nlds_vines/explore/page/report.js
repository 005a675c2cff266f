"use strict"
// What a page without a server adds: it unpacks the numbers that it carries, and shows what is stored
// of the chosen cell.
const REPORT = (() => {
  const {el, model, at} = NV
  const SIZES = {f4: 4, u2: 2, u1: 1, i1: 1}
  const ARRAYS = {f4: Float32Array, u2: Uint16Array, u1: Uint8Array, i1: Int8Array}
  let section = null

  async function unpack(meta) {
    const texts = el("packed").textContent.trim().split(/\s+/), found = {}
    for (const [n, {name, kind, length}] of meta.entries.entries()) {
      const bytes = Uint8Array.from(atob(texts[n]), (c) => c.charCodeAt(0))
      const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))
      const planes = new Uint8Array(await new Response(stream).arrayBuffer())
      const size = SIZES[kind], values = new Uint8Array(length * size)
      for (let b = 0; b < size; b++)
        for (let i = 0; i < length; i++) values[i * size + b] = planes[b * length + i]
      found[name] = new ARRAYS[kind](values.buffer)
    }
    return found
  }
  function state(lane, point, component) {
    const size = at.meta.components.length
    const code = section[(lane * at.meta.points + point) * size + component]
    const [low, high] = at.meta.ranges[component]
    return code === 65535 ? NaN : low + code * (high - low) / 65534
  }
  function pointsOf(meta) { // of a diagram: the displacements of all sections
    if (meta.axes.length > 1 || !meta.points) return null
    const found = {count: meta.points}, total = meta.rows * meta.points
    meta.components.forEach((name, c) => {
      const values = new Float32Array(total), [low, high] = meta.ranges[c]
      for (let i = 0; i < total; i++) {
        const code = section[i * meta.components.length + c]
        values[i] = code === 65535 ? NaN : low + code * (high - low) / 65534
      }
      found[name] = values
    })
    return found
  }
  function cell(i, j, k) {
    el("label").textContent = NV.labelOf(i, j, k) || NV.placed(i, j)
    const several = at.meta.starts.length > 1
    el("where").textContent = NV.placed(i, j) + (several ? `, start ${at.meta.starts[k]}` : "")
    const rows = NV.evidence(i, j, k)
    if (several && at.lanes.label) rows.unshift(["all starts", NV.others(i, j)])
    el("evidence").replaceChildren(...rows.map(([term, value]) => {
      const line = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd")
      dt.textContent = term
      dd.textContent = value
      line.append(dt, dd)
      return line
    }))
    if (!at.meta.points) return // the page carries no sections
    const data = {}
    at.meta.components.forEach((name, c) => {
      data[name] = Array.from({length: at.meta.points}, (_, p) => state(NV.row(i, j, k), p, c))
    })
    model("plane 1").renderers[0].data_source.data = data
    for (const [plane, c] of [["plane 1", 0], ["plane 2", 2]]) {
      if (!model(plane)) continue
      fit(model(plane).x_range, data[at.meta.components[c]], at.meta.ranges[c])
      fit(model(plane).y_range, data[at.meta.components[c + 1]], at.meta.ranges[c + 1])
    }
  }
  function fit(range, values, [low, high]) { // what there is; of one point, a tenth of all that there is
    const known = values.filter(Number.isFinite)
    if (!known.length) [low, high].forEach((end) => known.push(end))
    const center = (Math.min(...known) + Math.max(...known)) / 2
    const span = Math.max(...known) - Math.min(...known) // numbers are rounded to 1/65534 of all
    const half = span > 1e-3 * (high - low) ? 0.6 * span : 0.05 * (high - low)
    NV.put(range, {start: center - half, end: center + half})
  }
  function shown(name) { // of the lines of branches, those of the number that a diagram shows
    for (const r of model("map").renderers) {
      const of = (r.tags || []).find((t) => t.startsWith("of "))
      if (of) r.visible = of === `of ${name}`
    }
  }
  async function start() {
    const meta = JSON.parse(el("meta").textContent), found = await unpack(meta)
    section = found.section
    delete found.section
    const lanes = {}, cells = {}
    for (const [name, values] of Object.entries(found)) (values.length === meta.rows ? lanes : cells)[name] = values
    el("section").hidden = !meta.points
    NV.startPage()
    NV.listeners.chosen = cell
    NV.listeners.shown = shown
    NV.level(meta, lanes, cells, pointsOf(meta))
    el("map-head").textContent = meta.head
    shown(at.show.name)
    NV.choose(...at.cell)
    el("state").textContent = ""
    document.documentElement.dataset.ready = "yes"
  }
  return {start}
})()
