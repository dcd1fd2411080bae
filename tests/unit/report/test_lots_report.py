"""A report over several lots: a first page with each and the total, then the report of each."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import pytest

from hawk.cli import main
from hawk.lots import commands, lists
from hawk.lots.documents import parts
from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import pictures_of
from hawk.lots.values import FinishedSurvey
from hawk.model.poses import GlobalPose
from hawk.report import options
from hawk.report.document import lots_document
from hawk.report.files import finished, prepared_of_lots
from hawk.report.lots_report import LotLine, lots_report
from hawk.report.options import Form, Kind, Wanted
from hawk.stats.use_query import asked_of
from hawk.stats.values import Estimate
from tests.unit.lots.documents.drones import Drone, collected
from tests.unit.lots.plan.plans import FAST, Person
from tests.unit.lots.surveys import BEGAN, box, later, survey
from tests.unit.report.read_back import Book, Page, Print, pdf_writer
from tests.unit.stats.test_panel_sections import street
from tests.unit.stats.test_section_use import MONDAY

__all__ = ["street"]
NAMES = ["<b>North", "Elm Street", "Nobody", "South"]
NOW = MONDAY + 30 * 3600
HOUR = 3600.0


def at_place(given: FinishedSurvey, latitude: float) -> FinishedSurvey:
    """Return a survey of a lot elsewhere."""
    datum = GlobalPose(latitude, 5.0, 0.0)
    ground = box(-50, -20, 80, 120, datum)
    return replace(given, datum=datum, outline=ground, seen_ground=ground)


def after(number: int, hours: float) -> FinishedSurvey:
    """Return a survey that is flown so long after the first one of the street."""
    flown = (MONDAY - BEGAN) / HOUR + hours
    given = later(survey(seed=number), number, flown)
    stalls = (replace(each, looked_at=each.looked_at + flown * HOUR) for each in given.stalls)
    return replace(given, stalls=tuple(stalls))


@dataclass(frozen=True)
class City:
    folder: Path
    ids: dict[str, str]

    def file(self, kind: Kind, *names: str, **named: object) -> bytes:
        store = Database(self.folder / "lots.db", FAST)
        wanted = Wanted("", asked_of(None, None), **named)  # type: ignore[arg-type]
        due = {self.ids["South"]: datetime.fromtimestamp(NOW - HOUR, UTC)}
        with store.reading() as connection:
            lots = [self.ids[each] for each in names]
            file = prepared_of_lots(
                connection, pictures_of(self.folder / "lots.db"), lots, wanted, kind, Form(), NOW,
                lambda lot, *_: due.get(lot),
            )  # fmt: skip
        store.close()
        return finished(file)

    def page(self, *names: str, **named: object) -> Page:
        return Page.of(self.file("html", *names, **named).decode())


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, street: Person) -> City:
    """A street of sections, a lot that Drone 2 sent, one that was surveyed here, and one whose survey was deleted."""
    store, folder = street.store, tmp_path_factory.mktemp("city")
    drone = Drone.at(folder / "drone.db")
    north = drone.add(at_place(survey(stalls=60), 52.1))
    drone.do(commands.rename, north.lot, "<b>North", "operator", NOW)
    collected(store, parts.packed(drone.documents()[0]), "Drone 2")
    drone.store.close()
    south = Drone(store)
    first = south.add(at_place(after(2, 24.0), 52.2))
    south.do(commands.rename, first.lot, "South", "operator", NOW)
    gone = south.add(at_place(after(3, 25.0), 52.3))
    south.do(commands.rename, gone.lot, "Nobody", "operator", NOW)
    south.do(commands.delete, gone.survey, "operator", NOW)
    with store.reading() as connection:
        ids = {each.name: each.id for each in lists.lots(connection, lists.Asked()).items}
    store.close()
    assert sorted(ids) == NAMES
    shutil.copy(store.path, folder / "lots.db")
    return City(folder, ids)


@pytest.fixture
def city(made: City, tmp_path: Path) -> City:
    return City(Path(shutil.copytree(made.folder, tmp_path / "city")), made.ids)


def ends(text: str) -> tuple[int, int]:
    low, _, high = text.partition(" to ")
    return int(low), int(high)


@pytest.mark.nightly
def test_the_first_page_has_each_lot_with_its_newest_count_and_what_is_due(city: City) -> None:
    page = city.page(*NAMES)
    head, north, elm, nobody, south, total = page.tables["Lots"]
    assert head[0] == "Lot"
    assert [row[0] for row in (north, elm, nobody, south, total)] == [*NAMES, "Total"]
    assert [row[1] for row in (north, elm, nobody, south, total)] == ["60", "0", "40", "40", "100"]
    assert north[8:] == ["Drone 2", "–"]
    assert south[8] == "–"
    assert south[9].startswith("since ")
    assert "6 hours ago" in south[7]
    assert nobody[2:8] == ["–", "–", "–", "–", "–", "no survey that counts"]
    assert elm[2:4] == ["–", "–"]
    assert elm[4:7] == total[4:7]
    assert elm[6] == "8"
    assert "One lot has no survey that counts, and is in no total." in page.words


@pytest.mark.slow
def test_the_range_of_the_total_adds_the_ends_of_all_and_the_note_says_the_one_of_lots_that_err_apart(
    city: City,
) -> None:
    page = city.page("<b>North", "South")
    _, north, south, total = page.tables["Lots"]
    assert int(total[2]) == pytest.approx(int(north[2]) + int(south[2]), abs=1)
    (low, high), *each = (ends(row[3]) for row in (total, north, south))
    assert low == pytest.approx(sum(one for one, _ in each), abs=1)
    assert high == pytest.approx(sum(other for _, other in each), abs=1)
    apart = next(part for part in page.words.split("erred for itself, ") if " stalls would be free" in part)
    narrow = ends(apart.partition(" stalls")[0])
    assert low < narrow[0] < int(total[2]) < narrow[1] < high
    assert "as if all lots erred alike" in page.words
    assert "The total is of no single moment: the surveys are from " in page.words
    assert "vehicles" not in page.words


@pytest.mark.slow
def test_behind_it_is_the_report_of_each_lot(city: City) -> None:
    page = city.page("South", "<b>North", "South")
    articles = [each["id"] for each in page.attributes("article")]
    assert articles == ["part-0", "part-1", "part-2"], "a lot that is named twice is there once"
    assert [each.get("href") for each in page.attributes("a")] == ["#part-1", "#part-2"]
    assert page.words.count("how many stalls of the lot are taken") == 2
    assert not [each for each in page.attributes("script") + page.attributes("b") if each]
    assert page.words.index("2 lots") < page.words.index("Newest survey, ")


@pytest.mark.slow
def test_a_period_without_a_survey_says_so_of_each_lot(city: City) -> None:
    page = city.page("<b>North", "South", begin="2020-01-01", end="2020-01-02")
    assert [row[4] for row in page.tables["Lots"][1:3]] == ["no survey that counts"] * 2
    assert "2 lots have no survey that counts" in page.words
    assert "1 to 2 Jan 2020" in page.words


@pytest.mark.nightly
def test_the_workbook_has_a_sheet_of_all_lots_and_those_of_each(city: City) -> None:
    book = Book.of(city.file("xlsx", *NAMES))
    rows = book.sheets["Lots"]
    assert [row[1] for row in rows[1:5]] == NAMES
    assert {"1 Summary", "4 Summary", "2 Sections", "4 Stalls"} <= book.sheets.keys()
    alike, apart = rows[5], rows[6]
    assert alike[1] == "Total, as if all lots erred alike"
    assert (alike[2], alike[3]) == (100.0, apart[3])
    low, high = (float(str(each)) for each in alike[4:6])
    assert low < float(str(apart[4])) < float(str(alike[3])) < float(str(apart[5])) < high
    assert rows[1][12] == "Drone 2"
    assert not book.formulas


@pytest.fixture
def run(city: City, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str]]:
    def command(*given: str) -> tuple[int, str]:
        out = city.folder / "r.html"
        status = main(["report", *given, "--out", str(out), "--store", str(city.folder)])
        return status, capsys.readouterr().err if status else out.read_text()

    return command


@pytest.mark.slow
def test_the_command_takes_several_lots_or_all_and_says_when_they_are_due(
    run: Callable[..., tuple[int, str]], city: City
) -> None:
    settings = city.folder / "config.toml"
    settings.write_text('[[schedule]]\nlot = "South"\ndays = ["mon"]\nat = "08:00"\n')
    status, text = run("South", "<b>North", "--config", str(settings))
    assert status == 0
    south, north = Page.of(text).tables["Lots"][1:3]
    assert (south[0], north[0]) == ("South", "<b>North")
    assert "Mon" in south[-1]
    assert north[-1] == "–"
    status, text = run("--all")
    assert [row[0] for row in Page.of(text).tables["Lots"][1:-1]] == NAMES
    status, text = run("South")
    assert "Lots" not in Page.of(text).tables, "of one lot it is its report as ever"


@pytest.mark.slow
def test_what_cannot_be_reported_is_refused_with_the_remedy(
    run: Callable[..., tuple[int, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    for given, words in (
        ((), "LOT: name one or more lots, or write --all"),
        (("South", "--all"), "--all: means all lots; leave it out"),
        (("South", "Nowhere"), "LOT: no lot is called 'Nowhere'"),
        (("--all", "--row", "A"), "--row: is a part of one lot: leave it out, or ask for the report of that lot alone"),
    ):
        status, error = run(*given)
        assert status == 2, given
        assert words in error
    monkeypatch.setattr("hawk.report.lots_report.MOST_LOTS", 3)
    status, error = run("--all")
    assert status == 2
    assert "lot: a report is over 3 lots at most, and these are 4: ask for fewer, in several reports" in error
    assert options.MOST_LOTS == 50


@pytest.mark.slow
def test_names_without_a_space_and_counts_of_sections_stay_on_the_paper() -> None:
    weasyprint = pytest.importorskip("weasyprint")
    at, free = datetime(2026, 11, 18, 14, 5, tzinfo=UTC), Estimate(1200.0, 1100.0, 1300.0, 1)
    lines = [
        LotLine("0", name, "Europe/Amsterdam", at.date(), at.date(), 2000, free, 0, free, 2000, at, "Drone 12", at)
        for name in ("W" * 80, "Elm Street")
    ]
    html = lots_document(lots_report(lines, asked_of(None, None), NOW), [], Form("fr", "a4"))
    page = weasyprint.HTML(string=html).render().pages[0]
    texts = [box for box in page._page_box.descendants() if type(box).__name__ == "TextBox"]
    assert max(box.position_x + box.width for box in texts) <= page.width - 56
    dates = [box for box in texts if "2026" in box.text and "18" in box.text]
    assert len(dates) == 4, "day and year on one line"


@pytest.fixture(scope="module")
def group(made: City) -> Print:
    """Three lots as PDF, which no test changes."""
    pdf_writer()
    return Print.of(made.file("pdf", "South", "<b>North", "Elm Street"))


@pytest.mark.slow
def test_a_pdf_has_a_bookmark_a_lot_and_the_first_page_leads_to_each(group: Print, city: City) -> None:
    titles, tops = zip(*group.bookmarks, strict=True)
    assert titles == ("3 lots", "South", "<b>North", "Elm Street")
    assert list(tops) == [0, *dict.fromkeys(group.links)]  # a name on two lines is a link on each
    assert list(tops) == sorted(set(tops))
    alone = [len(Print.of(city.file("pdf", name)).pages) - 1 for name in ("South", "<b>North")]
    assert [later - top for top, later in pairwise(tops[1:])] == alone
    assert len(group.pages) > tops[-1]


@pytest.mark.slow
def test_a_pdf_of_several_lots_has_the_title_of_all_and_the_language(group: Print) -> None:
    assert str(group.file.docinfo.Title).startswith("3 lots, Parking survey report")
    assert str(group.file.docinfo.Subject).startswith("Parking survey report")
    assert str(group.file.docinfo.Author).startswith("Parking Lot Hawk")
    assert str(group.file.Root.Lang) == "en"
    assert group.file.Root.MarkInfo.Marked


@pytest.mark.slow
def test_a_reader_by_voice_finds_each_page_link_and_head_of_a_table_of_every_lot(group: Print) -> None:
    group.check_structure()
    assert group.kinds["/Document"] == 1
    assert group.kinds["/Link"] == len(group.links)
    assert len(group.ids) == len(set(group.ids))
    assert group.heads == set(group.ids)
    assert {each.partition("-")[0] for each in group.ids if each.count("-") == 3} == {"1", "2", "3"}
