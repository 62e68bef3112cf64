"""Pictures at the end of a run. What draws them is imported only then: nobody waits for it before the table."""

from nervure.simulation.loop import Observer
from nervure.simulation.results import Results
from nervure.simulation.session import Session


class Pictures(Observer):
    """Draws the pictures of a session after its results are written."""

    def __init__(self, session: Session):
        self.session = session

    def finish(self, results: Results) -> None:
        from nervure.output import plots

        plots.write(results.folder, [results])
        if results.summary.error is None and (figure := plots.vorticity(self.session)):
            plots.save(figure, results.folder / "vorticity.png")
        if mesh := results.facts.wing:
            from nervure.output import wings

            plots.save(wings.draw(self.session, mesh), results.folder / "wing.png")
