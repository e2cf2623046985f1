//! The right answer about a ray, by the kind of ray that a row makes of it.

use raxel_oracle::exact::Answer;
use raxel_oracle::instances::SceneHit;
use raxel_oracle::metrics::{Errors, Outcome, Wrong};
use raxel_oracle::period::{PeriodHit, PeriodRay};
use raxel_oracle::{Hit, Oracle, Ray};

use super::plan::{Kind, Row};

/// The right answer about a ray.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    /// Of the ray itself.
    Ray(Answer),
    /// Of the period ray next to it.
    Period(PeriodRay, Option<PeriodHit>),
    /// Of the ray through the world with instances.
    Scene(Option<SceneHit>),
    /// Of the ray through the world with edits that a publication shows.
    Edited(Answer),
}

impl Truth {
    /// The right answer about a ray for a row; for a streamed one, `oracle` is that of the world that a publication shows.
    pub(super) fn of(row: &Row, ray: &Ray, oracle: &Oracle<'_>) -> Self {
        match row.kind() {
            Kind::Rays
            | Kind::Ahead
            | Kind::Tiles
            | Kind::Instances
            | Kind::Onward
            | Kind::OnwardInstances
            | Kind::Stored => Self::Ray(oracle.first_hit(ray)),
            Kind::Streamed => Self::Edited(oracle.first_hit(ray)),
            Kind::Periods => {
                let period = period_ray(ray);
                Self::Period(period, period.first_hit(oracle))
            }
        }
    }

    /// Adds a row's hit of the ray to its counts, and returns the mistake if it is wrong.
    pub fn judge(&self, errors: &mut Errors, ray: &Ray, row: &Row, outcome: Outcome<'_>) -> Option<Wrong> {
        match self {
            Self::Ray(answer) | Self::Edited(answer) => {
                let steps = if let Outcome::Hit(hit) = outcome { row.steps(ray, hit) } else { 0..=0 };
                errors.add_with_numbers(ray, answer, outcome, steps)
            }
            Self::Period(period, exact) => {
                let wrong = period.judge(exact.as_ref(), outcome);
                errors.add_judged(exact.is_some(), exact.is_some_and(|hit| period.ties(&hit)), wrong);
                wrong
            }
            // Of these more than a hit is judged, see posed.rs.
            Self::Scene(_) => None,
        }
    }
}

/// A ray that has no period ray next to it.
const NOTHING: PeriodRay = PeriodRay { cell: [0; 3], octant: 0, first: [0; 3], period: [0; 3] };

/// The period ray that is traced for a ray: the one next to it, every other one rounded so that it meets edges and corners.
pub(super) fn period_ray(ray: &Ray) -> PeriodRay {
    let Some(near) = PeriodRay::near(ray) else { return NOTHING };
    // By its bits, so that it is the same alone.
    let bits = ray.cell.iter().fold(ray.dir[0].to_bits() >> 3, |bits, cell| bits ^ cell.cast_unsigned());
    if bits & 1 == 1 { near.coarse() } else { near }
}

/// The outcome that the device, or the port, reports of a ray, for a given hit.
pub(super) fn outcome<'h>(hit: Option<&'h Hit>, other: Outcome<'h>) -> Outcome<'h> {
    hit.map_or(other, Outcome::Hit)
}
