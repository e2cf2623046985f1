//! Pinned texels: they stay while other passes, resources and mips are shown. One of them is active.

use raxel_execute::{Region, Texels};

use super::locate::scaled;

/// Most pins at once.
pub(crate) const MOST: usize = 8;

/// Pixels of the output from a pin within which the cursor is on it.
const REACH: f64 = 6.0;

/// A pinned texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// Its number, from 1 on.
    pub number: u32,
    /// Its place.
    pub texel: [u32; 2],
    /// Extent of the picture that it was pinned in.
    pub extent: [u32; 2],
    /// A search has pinned it, and its next result takes its place.
    found: bool,
}

impl Pin {
    /// Its place in a picture, which may have another extent than the one it was pinned in.
    pub(crate) fn place_in(&self, extent: [u32; 2]) -> [u32; 2] {
        scaled(self.texel, self.extent, extent)
    }
}

/// The effect of a press of the key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pressed {
    /// The texel is pinned now.
    Pinned,
    /// The pin under the cursor is gone.
    Unpinned,
    /// There are [`MOST`] pins already.
    Full,
    /// No texel is under the cursor.
    Nothing,
}

/// The pins, in the order of their numbers.
#[derive(Debug, Default)]
pub(crate) struct Pins {
    pins: Vec<Pin>,
    /// Number of the active one.
    active: u32,
}

impl Pins {
    /// All of them.
    pub(crate) fn all(&self) -> &[Pin] {
        &self.pins
    }

    /// The one whose history is shown.
    pub(crate) fn active(&self) -> Option<Pin> {
        self.pins.iter().copied().find(|pin| pin.number == self.active)
    }

    /// Pins a texel, which becomes the active one. False when there are [`MOST`] pins.
    pub(crate) fn add(&mut self, texel: [u32; 2], extent: [u32; 2]) -> bool {
        if self.pins.len() >= MOST {
            return false;
        }
        // The numbers are below 1 + MOST, so that one of them is free.
        let free = (1..).zip(&self.pins).find(|(number, pin)| pin.number != *number).map(|(number, _)| number);
        let number = free.unwrap_or_else(|| self.pins.last().map_or(1, |last| last.number + 1));
        self.pins.push(Pin { number, texel, extent, found: false });
        self.pins.sort_by_key(|pin| pin.number);
        self.active = number;
        true
    }

    /// Pins what a search has found, in place of the active pin if a search has pinned that, too, or if there is no room for another.
    pub(crate) fn add_found(&mut self, texel: [u32; 2], extent: [u32; 2]) {
        let replaces = self.active().is_some_and(|pin| pin.found) || !self.add(texel, extent);
        if replaces {
            self.go(self.active, texel, extent);
        }
        if let Some(pin) = self.pins.iter_mut().find(|pin| pin.number == self.active) {
            pin.found = true;
        }
    }

    /// Puts a pin elsewhere.
    pub(crate) fn go(&mut self, number: u32, texel: [u32; 2], extent: [u32; 2]) {
        if let Some(pin) = self.pins.iter_mut().find(|pin| pin.number == number) {
            (pin.texel, pin.extent, pin.found) = (texel, extent, false);
        }
    }

    /// Makes a pin the active one.
    pub(crate) fn choose(&mut self, number: u32) {
        if self.pins.iter().any(|pin| pin.number == number) {
            self.active = number;
        }
    }

    /// Lets go of a pin. If it was the active one, the one before it is.
    pub(crate) fn remove(&mut self, number: u32) {
        self.pins.retain(|pin| pin.number != number);
        if self.active == number {
            let before = self.pins.iter().rev().find(|pin| pin.number < number).or(self.pins.first());
            self.active = before.map_or(0, |pin| pin.number);
        }
    }

    /// The pin of a texel, or within some pixels of the output around the cursor: the nearest one.
    pub(crate) fn under(
        &self,
        texels: &Texels,
        at: [u32; 2],
        pixel: [i32; 2],
        output: [u32; 2],
        region: &Region,
    ) -> Option<u32> {
        let extent = [texels.width, texels.height];
        let distance = |pin: &Pin| {
            let place = pin.place_in(extent);
            let apart = |axis: usize| {
                let share = (f64::from(place[axis]) + 0.5) / f64::from(extent[axis].max(1));
                let shown = (share - region.origin[axis]) / region.size * f64::from(output[axis]);
                shown - f64::from(pixel[axis]) - 0.5
            };
            if place == at { 0.0 } else { apart(0).hypot(apart(1)) }
        };
        let near = self.pins.iter().map(|pin| (distance(pin), pin.number)).filter(|(distance, _)| *distance <= REACH);
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, number)| number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(pins: &Pins) -> Vec<u32> {
        pins.all().iter().map(|pin| pin.number).collect()
    }

    #[test]
    fn numbers_are_used_again_and_there_are_no_more_than_eight() {
        let mut pins = Pins::default();
        assert!((0..8).all(|x| pins.add([x, 0], [16, 16])) && !pins.add([9, 0], [16, 16]));
        pins.remove(3);
        assert_eq!(pins.active().unwrap().number, 8, "another one goes");
        assert!(pins.add([12, 0], [16, 16]));
        assert_eq!((numbers(&pins), pins.active().unwrap()), ((1..=8).collect(), pins.all()[2]));
        pins.remove(3);
        assert_eq!(pins.active().unwrap().number, 2, "the one before");
        pins.choose(3);
        assert_eq!(pins.active().unwrap().number, 2, "there is none of that number");
        (1..=8).for_each(|number| pins.remove(number));
        assert_eq!((pins.all(), pins.active()), (&[][..], None));
    }

    #[test]
    fn what_is_found_takes_the_place_of_what_was_found_before() {
        let (mut pins, extent) = (Pins::default(), [16, 16]);
        pins.add([1, 1], extent);
        for x in 5..8 {
            pins.add_found([x, 5], extent);
        }
        let places: Vec<_> = pins.all().iter().map(|pin| pin.texel).collect();
        assert_eq!((places, pins.active().unwrap().number), (vec![[1, 1], [7, 5]], 2));
        // One that was moved by hand is the user's.
        pins.go(2, [8, 8], extent);
        pins.add_found([9, 5], extent);
        assert_eq!(numbers(&pins), [1, 2, 3]);
        (4..=8).for_each(|x| assert!(pins.add([x, 0], extent)));
        pins.add_found([3, 3], extent);
        assert_eq!((pins.all().len(), pins.active().unwrap().texel), (8, [3, 3]));
    }
}
