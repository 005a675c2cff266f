// A button on each block of code that copies it.
document.addEventListener("DOMContentLoaded", () => {
  if (!navigator.clipboard) return // pages opened from a file in some browsers have none
  for (const block of document.querySelectorAll("div.highlight")) {
    const button = document.createElement("button")
    button.className = "copy"
    button.type = "button"
    button.textContent = "copy"
    button.setAttribute("aria-label", "copy this code")
    button.addEventListener("click", async () => {
      await navigator.clipboard.writeText(block.querySelector("pre").textContent.trimEnd() + "\n")
      button.textContent = "copied"
      setTimeout(() => { button.textContent = "copy" }, 1500)
    })
    block.append(button)
  }
})
