"""Studies: what is run, and what came of it as a document, as text and as a page, the same way for every experiment."""

from mmt_drake.diagrams.proof.studies.study import Asked, Report, Study

__all__ = ["Asked", "Report", "Study"]
