//! Searches the slices of a picture for a value: NaN, infinity, the smallest, the largest.

/// Properties by which values can be sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    /// NaN.
    Nan,
    /// Plus or minus infinity.
    Infinite,
    /// The smallest finite value.
    Smallest,
    /// The largest finite value.
    Largest,
}

impl Sought {
    /// All of them.
    pub const ALL: [Sought; 4] = [Sought::Nan, Sought::Infinite, Sought::Smallest, Sought::Largest];

    /// A word for it.
    pub fn word(self) -> &'static str {
        match self {
            Sought::Nan => "NaN",
            Sought::Infinite => "infinite",
            Sought::Smallest => "smallest",
            Sought::Largest => "largest",
        }
    }

    /// Whether it can be told only once all values are known.
    fn needs_all(self) -> bool {
        matches!(self, Sought::Smallest | Sought::Largest)
    }

    /// The smallest or the largest of finite values.
    fn extreme(self, values: impl Iterator<Item = f32>) -> Option<f32> {
        let finite = values.filter(|value| value.is_finite());
        match self {
            Sought::Smallest => finite.reduce(f32::min),
            Sought::Largest => finite.reduce(f32::max),
            Sought::Nan | Sought::Infinite => None,
        }
    }
}

/// A value of a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Number of the slice.
    pub slice: usize,
    /// Number of the value in the slice.
    pub index: usize,
}

/// A search from slice to slice, and round again. It keeps no values, so its memory does not grow with the slices.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    sought: Sought,
    forward: bool,
    slices: usize,
    /// Where it begins: after this value of the slice, or with all of the slice.
    start: (usize, Option<usize>),
    looked: usize,
    /// The smallest or the largest value so far.
    best: Option<f32>,
    found: Option<Place>,
    /// In the slice where the search begins, on the other side of its start: it comes last.
    round: Option<Place>,
}

impl Search {
    /// A search in `slices` slices, forward or back, from a value of a slice on.
    pub fn new(sought: Sought, forward: bool, slices: usize, slice: usize, from: Option<usize>) -> Self {
        let start = (slice.min(slices.saturating_sub(1)), from);
        Self { sought, forward, slices, start, looked: 0, best: None, found: None, round: None }
    }

    /// The slice to look at next; `None` once the search has ended.
    pub fn slice(&self) -> Option<usize> {
        self.upcoming(0)
    }

    /// The slice to look at after `ahead` others; `None` if the search ends before.
    pub fn upcoming(&self, ahead: usize) -> Option<usize> {
        let looked = self.looked.saturating_add(ahead);
        let ended = looked >= self.slices || (self.found.is_some() && !self.sought.needs_all());
        let step = |looked| if self.forward { looked } else { self.slices - looked };
        (!ended).then(|| (self.start.0 + step(looked)) % self.slices)
    }

    /// Looks at the values of [`Self::slice`].
    pub fn look(&mut self, values: &[f32]) {
        let Some(slice) = self.slice() else { return };
        let from = self.start.1.filter(|_| self.looked == 0);
        self.looked += 1;
        if self.sought.needs_all() {
            let Some(extreme) = self.sought.extreme(values.iter().copied()) else { return };
            // Equal values of two slices are both the smallest.
            if self.sought.extreme([extreme].into_iter().chain(self.best)) != self.best {
                (self.best, self.found, self.round) = (Some(extreme), None, None);
            }
        }
        let place = |index: Option<usize>| index.map(|index| Place { slice, index });
        let [ahead, behind] = self.in_slice(values, from).map(place);
        self.found = self.found.or(ahead);
        self.round = self.round.or(behind);
    }

    /// The first sought values of a slice ahead of a start, and behind it.
    fn in_slice(&self, values: &[f32], from: Option<usize>) -> [Option<usize>; 2] {
        let is_it = |index: &usize| match self.sought {
            Sought::Nan => values[*index].is_nan(),
            Sought::Infinite => values[*index].is_infinite(),
            Sought::Smallest | Sought::Largest => self.best == Some(values[*index]),
        };
        let count = values.len();
        match (from.map(|from| from.min(count)), self.forward) {
            (None, true) => [(0..count).find(is_it), None],
            (None, false) => [(0..count).rev().find(is_it), None],
            (Some(from), true) => {
                let next = (from + 1).min(count);
                [(next..count).find(is_it), (0..next).find(is_it)]
            }
            (Some(from), false) => [(0..from).rev().find(is_it), (from..count).rev().find(is_it)],
        }
    }

    /// The found value, once the search has ended; `None` if there is none. The value where it began counts last.
    pub fn found(&self) -> Option<Place> {
        self.found.or(self.round)
    }

    /// Slices that were looked at, and all.
    pub fn progress(&self) -> [usize; 2] {
        [self.looked, self.slices]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f32 = f32::NAN;

    /// The places that a search finds one after the other, as slice and index.
    fn all<const N: usize>(slices: &[&[f32]], sought: Sought, forward: bool) -> [(usize, usize); N] {
        let mut from = (0, None);
        [(); N].map(|()| {
            let mut search = Search::new(sought, forward, slices.len(), from.0, from.1);
            while let Some(slice) = search.slice() {
                search.look(slices[slice]);
            }
            let Place { slice, index } = search.found().unwrap();
            from = (slice, Some(index));
            (slice, index)
        })
    }

    #[test]
    fn values_of_one_slice_are_found_in_order_and_round_again() {
        let slice: &[&[f32]] = &[&[1.0, NAN, f32::INFINITY, 3.0, NAN, 1.0]];
        assert_eq!(all(slice, Sought::Nan, true), [(0, 1), (0, 4), (0, 1)]);
        assert_eq!(all(slice, Sought::Nan, false), [(0, 4), (0, 1), (0, 4)]);
        assert_eq!(all(slice, Sought::Infinite, true), [(0, 2); 3]);
        assert_eq!(all(slice, Sought::Smallest, true), [(0, 0), (0, 5), (0, 0)]);
        assert_eq!(all(slice, Sought::Largest, false), [(0, 3); 3]);
    }

    #[test]
    fn values_of_all_slices_are_found_in_order_and_round_again() {
        let slices: &[&[f32]] = &[&[2.0, NAN], &[0.0, 1.0], &[], &[NAN, 7.0, NAN], &[7.0, 0.0]];
        assert_eq!(all(slices, Sought::Nan, true), [(0, 1), (3, 0), (3, 2), (0, 1)]);
        assert_eq!(all(slices, Sought::Nan, false), [(0, 1), (3, 2), (3, 0), (0, 1)]);
        assert_eq!(all(slices, Sought::Smallest, true), [(1, 0), (4, 1), (1, 0)]);
        assert_eq!(all(slices, Sought::Largest, false), [(4, 0), (3, 1), (4, 0)]);
    }

    #[test]
    fn a_search_ends_where_nothing_is_left_to_look_at() {
        let mut search = Search::new(Sought::Nan, true, 3, 2, Some(9));
        let mut order = Vec::new();
        while let Some(slice) = search.slice() {
            order.push(slice);
            search.look(&[1.0, 2.0]);
        }
        assert_eq!((order, search.found(), search.progress()), (vec![2, 0, 1], None, [3, 3]));
        search.look(&[NAN]);
        assert_eq!(search.found(), None, "it has ended");
        // The first slice that has one ends it.
        let mut search = Search::new(Sought::Nan, false, 3, 0, None);
        search.look(&[1.0]);
        assert_eq!([search.slice(), search.upcoming(1), search.upcoming(2)], [Some(2), Some(1), None]);
        search.look(&[NAN, NAN]);
        assert_eq!((search.slice(), search.found()), (None, Some(Place { slice: 2, index: 1 })));
        assert_eq!(Search::new(Sought::Largest, true, 0, 0, None).slice(), None);
        // No finite value is the largest.
        let mut search = Search::new(Sought::Largest, true, 1, 0, None);
        search.look(&[NAN, f32::INFINITY]);
        assert_eq!(search.found(), None);
    }
}
