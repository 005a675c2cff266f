"use strict"
// What the page of the server adds: it asks the server through the source `asked`, and hears from it
// through the source `told`.
const EXPLORE = (() => {
  const {el, model} = NV
  let number = 0
  function ask(what, more = {}) {
    number += 1
    model("asked").data = {message: [JSON.stringify({do: what, number, ...more})]}
  }
  const columns = (name) => {
    const found = {}
    for (const [key, values] of Object.entries(model(name).data)) found[key] = values
    return found
  }
  function points(meta) {
    return {...columns("points"), ...columns("touched"), count: meta.points}
  }

  // ---- what the server tells

  function hear(message) {
    for (const [key, value] of Object.entries(message)) (HEARD[key] || (() => {}))(value, message)
  }
  const HEARD = {
    level: (meta) => {
      NV.level(meta, columns("lanes"), columns("cells"), points(meta))
      el("title").textContent = meta.title
      el("map-head").textContent = meta.head
    },
    cells: (meta) => NV.refresh(meta, columns("lanes"), columns("cells"), points(meta)),
    state: (text) => { el("state").textContent = text },
    orbit: (orbit) => {
      fill(orbit.layout)
      el("label").textContent = orbit.label
      el("words").textContent = orbit.words
      el("where").textContent = orbit.where
      el("evidence").replaceChildren(...orbit.evidence.map(([term, value]) => {
        const line = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd")
        dt.textContent = term
        dd.textContent = value
        line.append(dt, dd)
        return line
      }))
      el("command").textContent = orbit.command
      drawn(orbit.number)
    },
    trouble: (text) => { el("trouble").textContent = text },
    job: (job) => {
      el("progress").hidden = el("cancel").hidden = !job.running
      el("progress").value = job.share
      el("job").textContent = job.text
      el("back").disabled = !job.back
      el("forward").disabled = !job.forward
    },
    sliders: (values) => {
      for (const [name, value] of Object.entries(values)) SLIDERS.set(name, value)
    },
    file: (file) => save(file),
  }
  const SOURCES = ["history", "phase1", "phase2", "section", "touches", "spectrum", "multipliers"].map((n) => `${n} data`)
  function fill(layout) { // the sources of the figures, from the one array that was sent
    // a system without a damper has fewer figures, and no source that none of them reads
    const {values} = model("values").data, found = new Map()
    if (!layout.length) { // no orbit: nothing of the one before remains
      for (const source of SOURCES.filter(model)) {
        const names = Object.keys(model(source).data)
        NV.put(model(source), {data: Object.fromEntries(names.map((name) => [name, new Float32Array(0)]))})
      }
    }
    for (const [source, name, first, stop] of layout) {
      if (!found.has(source)) found.set(source, {})
      found.get(source)[name] = new Float32Array(values.buffer, values.byteOffset + 4 * first, stop - first)
    }
    for (const [source, data] of found) if (model(source)) NV.put(model(source), {data})
  }
  function drawn(which) { // after the frame in which Bokeh has drawn what it was told
    requestAnimationFrame(() => requestAnimationFrame(() => {
      window.drawn = {number: which, time: performance.now()}
    }))
  }
  function save(file) {
    const bytes = file.base64 ? Uint8Array.from(atob(file.base64), (c) => c.charCodeAt(0)) : file.text
    const link = document.createElement("a")
    link.href = URL.createObjectURL(new Blob([bytes], {type: file.type}))
    link.download = file.name
    link.click()
    setTimeout(() => URL.revokeObjectURL(link.href), 10000)
  }

  // ---- sliders

  const SLIDERS = (() => {
    const found = {}
    function make(entries) {
      const home = el("sliders")
      for (const entry of entries) {
        const box = document.createElement("div"), text = document.createElement("label")
        const range = document.createElement("input"), exact = document.createElement("input")
        box.className = "slider"
        text.textContent = `${entry.symbol}${entry.unit ? ` [${entry.unit}]` : ""} · ${entry.meaning}`
        text.htmlFor = `slider-${entry.name}`
        Object.assign(range, {type: "range", id: `slider-${entry.name}`, min: 0, max: 1000, step: 1})
        Object.assign(exact, {type: "number", step: "any"})
        exact.setAttribute("aria-label", `${entry.name}, exact value`)
        range.addEventListener("input", () => send(entry.name, valueOf(entry, Number(range.value))))
        exact.addEventListener("change", () => { if (exact.value !== "") send(entry.name, Number(exact.value)) })
        box.append(text, range, exact)
        home.append(box)
        found[entry.name] = {entry, box, range, exact}
        set(entry.name, entry.value)
      }
    }
    function valueOf(entry, place) {
      const s = place / 1000
      const v = entry.logarithmic ? entry.low * (entry.high / entry.low) ** s : entry.low + s * (entry.high - entry.low)
      return Number(v.toPrecision(5))
    }
    function set(name, value) {
      const one = found[name]
      if (!one) return
      const {entry} = one
      const s = entry.logarithmic
        ? Math.log(value / entry.low) / Math.log(entry.high / entry.low)
        : (value - entry.low) / (entry.high - entry.low)
      if (document.activeElement !== one.range) one.range.value = Math.round(1000 * Math.min(1, Math.max(0, s)))
      const near = Number(value.toPrecision(7)), size = Math.abs(near)
      one.exact.value = size >= 1e7 || (size > 0 && size < 1e-4) ? near.toExponential() : String(near)
      one.box.classList.toggle("changed", value !== entry.value && !entry.axis)
    }
    function send(name, value) {
      set(name, value)
      ask("slider", {name, value})
    }
    return {make, set}
  })()

  // ---- the part of a map to compute finer

  function rectangle(g) {
    if (g.type !== "rect") return
    finer(g.x0, g.x1, g.y0, g.y1)
  }
  function finer(x0, x1, y0, y1) {
    const [a, b] = NV.at.meta.axes, order = (u, v) => u < v ? [u, v] : [v, u]
    const ranges = [order(NV.valueAt(a, x0), NV.valueAt(a, x1))]
    if (NV.isMap()) ranges.push(order(NV.valueAt(b, y0), NV.valueAt(b, y1)))
    ask("finer", {ranges})
  }
  function finerHere() {
    const {x_range: x, y_range: y} = model("map")
    finer(x.start, x.end, y.start, y.end)
  }

  function start(sliders) {
    NV.startPage()
    if (innerWidth <= 980) el("parameters").open = false // on a phone the orbit comes before the sliders
    NV.listeners.chosen = (i, j, start) => ask("cell", {cell: [i, j], start})
    NV.listeners.shown = (name) => ask("show", {name})
    SLIDERS.make(sliders)
    model("told").properties.data.change.connect(() => {
      for (const text of model("told").data.message) hear(JSON.parse(text))
    })
    for (const name of ["back", "forward", "cancel", "original", "recompute"])
      el(name).addEventListener("click", () => ask(name))
    el("history").value = "settled" // some browsers keep the choice of a page that is loaded again
    el("history").addEventListener("change", (e) => {
      Bokeh.index.find_one_by_id(model("displacement").id).reset_range() // other periods are shown
      ask("history", {name: e.target.value})
    })
    el("here").addEventListener("click", finerHere)
    for (const button of document.querySelectorAll("[data-save]"))
      button.addEventListener("click", () => ask("save", {what: button.dataset.save}))
    ask("ready")
  }
  return {start, ask, rectangle, hear}
})()
