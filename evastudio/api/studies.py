"""Routes: studies of people, as in the paper's table 3, kept where somebody agreed to it."""

from __future__ import annotations

import time

from fastapi import APIRouter, status

from evastudio.api.context import Studio
from evastudio.api.models.common import Page
from evastudio.api.models.studies import StudyIn, StudyOut
from evastudio.api.paging import NumberedPage
from evastudio.demonstrations.store import Store
from evastudio.evaluation import studies
from evastudio.evaluation.studies import Study

router = APIRouter(prefix="/studies", tags=["studies"])


@router.get("")
def list_studies(studio: Studio, paging: NumberedPage) -> Page[StudyOut]:
    """The studies kept, in the order in which they were made."""
    return paging.page(
        StudyOut, lambda after, limit: studies.study_records(studio.store, after, limit)
    )


@router.post("", status_code=status.HTTP_201_CREATED)
def keep_study(body: StudyIn, studio: Studio) -> StudyOut:
    """Keep how long somebody was taught and, from a session's takes, how long they demonstrated."""
    made = studies.save_study(studio.store, _study(body, studio.store), time.time())
    return StudyOut.model_validate(studies.find_study(studio.store, made))


@router.put("/{study}")
def replace_study(study: int, body: StudyIn, studio: Studio) -> StudyOut:
    """The same of the same person once more, after they demonstrated further."""
    studies.replace_study(studio.store, study, _study(body, studio.store))
    return StudyOut.model_validate(studies.find_study(studio.store, study))


@router.delete("/{study}", status_code=status.HTTP_204_NO_CONTENT)
def forget_study(study: int, studio: Studio) -> None:
    """Delete a study for good, as the person may want who agreed to it."""
    studies.forget_study(studio.store, study)


def _study(body: StudyIn, store: Store) -> Study:
    session = store.session(body.session)
    return Study(session.scene, body.person, body.instructed_s, session.seconds, body.preferred)
