// Functions and classes show what they are in a sentence, and the rest when they are opened. A link to
// one opens it, and so does the browser's own search where it can.
document.addEventListener("DOMContentLoaded", () => {
  const rests = new Map() // of each entry, what is folded
  function fold(entry) {
    const head = entry.querySelector(":scope > dt"), body = entry.querySelector(":scope > dd")
    if (!head || !body || body.children.length < 2) return
    const rest = document.createElement("div")
    rest.append(...[...body.children].slice(1))
    body.append(rest)
    const button = document.createElement("button")
    button.className = "fold"
    button.type = "button"
    button.addEventListener("click", () => set(rest.hidden))
    function set(open) {
      rest.hidden = open ? false : "until-found"
      button.textContent = open ? "less" : "more"
      button.setAttribute("aria-expanded", String(open))
    }
    rest.addEventListener("beforematch", () => set(true))
    body.insertBefore(button, rest)
    set(false)
    rests.set(entry, set)
  }
  function openTarget() {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)))
    for (let at = target; at; at = at.parentElement) if (rests.has(at)) rests.get(at)(true)
    if (target && target.closest("dl.py")) target.scrollIntoView()
  }
  for (const entry of document.querySelectorAll("section > dl.py")) fold(entry)
  addEventListener("hashchange", openTarget)
  addEventListener("beforeprint", () => rests.forEach((set) => set(true)))
  openTarget()
})
