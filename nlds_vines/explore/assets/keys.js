const steps = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}
let pressed = 0
document.addEventListener("keydown", (event) => {
  const step = steps[event.key], far = event.shiftKey ? 10 : 1
  if (!step || event.ctrlKey || event.metaKey || event.altKey) return
  if (event.composedPath()[0].closest("input, select, textarea, .noUi-handle")) return
  event.preventDefault()
  pressed += 1
  target.text = `${far * step[0]} ${far * step[1]} ${pressed}`
})
