"""The page of Figure 8 with the claims."""

import paper_results
import pytest
from paper_worlds import RESULTS

from paper import claims_page
from paper.claims import CLAIMS
from paper.claims.measured import not_followed
from paper.command import main

pytest.importorskip("bokeh")


@pytest.mark.slow("a page of 1201 orbits")
def test_the_page_has_the_diagram_and_every_claim(tmp_path, monkeypatch):
    monkeypatch.setattr(claims_page, "motions_of", not_followed)
    requests = paper_results.requests()
    paper_results.write_figure(tmp_path, "8", RESULTS["published"])
    output = tmp_path / "page.html"
    claims_page.write_page(output, tmp_path, requests, requests["8"].archive)
    html = output.read_text(encoding="utf-8")
    table = html[html.index("<h2>The claims of the paper</h2>") :]
    assert table[: table.index("</table>")].count("<tr><td>") == len(CLAIMS)
    assert "not computed" in table


def test_a_page_without_its_figure_is_refused(here, capsys):
    assert main(["--only", "3", "--page", "page.html"]) == 2
    assert "--page shows figure 8" in capsys.readouterr().err
    (here / "page.html").write_text("mine")
    assert main(["--page", "page.html"]) == 2
    assert "page.html" in capsys.readouterr().err
    assert (here / "page.html").read_text() == "mine"
