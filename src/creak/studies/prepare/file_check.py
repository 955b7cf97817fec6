"""What a run refuses of a study whatever its deck holds."""

from __future__ import annotations

from creak.contact.play import check_play
from creak.studies.design.clips import check_clips
from creak.studies.file.reader import Study
from creak.studies.prepare.excitation import count_steps
from creak.studies.prepare.pairs import contact_law, plays_of
from creak.studies.prepare.setup import check_frequencies


def check_file(study: Study) -> None:
    """Check names, laws and limits of what may touch, and how fast and how long the run is; no deck is read.

    Raises
    ------
    InputError : as setting up has it.
    """
    touching, course = study.touching, study.course
    check_clips(touching)
    for play, where in plays_of(touching):
        check_play(play, where)
    for name, table in touching.contacts.items():
        contact_law(table, touching.places.where("contact", name))
    check_frequencies(study.config.reduction, course.time, study.driving)
    if course.time.exact:
        _ = course.end  # steps follow from it
    else:
        count_steps(course, course.time.substeps)
