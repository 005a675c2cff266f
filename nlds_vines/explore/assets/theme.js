// light or dark: what the system asks for, until the button is used; paper is light
const dark = matchMedia("(prefers-color-scheme: dark)"), root = document.documentElement
function paint(theme) {
  root.dataset.theme = theme
  for (const view of Bokeh.index.query((v) => v.model.type === "Figure")) {
    view.request_repaint() // of all its layers,
    view.paint() // now: paper does not wait
  }
}
root.dataset.theme = dark.matches ? "dark" : "light"
const TURN = () => paint(root.dataset.theme === "dark" ? "light" : "dark")
let before = "light"
dark.addEventListener("change", () => paint(dark.matches ? "dark" : "light"))
addEventListener("beforeprint", () => { before = root.dataset.theme; paint("light") })
addEventListener("afterprint", () => paint(before))
