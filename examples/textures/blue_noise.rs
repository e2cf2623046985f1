//! Spatio-temporal blue noise: pictures that are blue noise each, and whose values at any one pixel are blue noise over time.
//!
//! Void and cluster (R. Ulichney, "The void-and-cluster method for dither array generation", 1993) with the energy of "Spatiotemporal
//! Blue Noise Masks" (A. Wolfe et al., EGSR 2022): two points repel each other if they are in the same picture, by their distance in
//! it, or at the same pixel, by their distance in time; else they do not know of each other. All three axes wrap around. Energies are
//! whole numbers, so that nothing drifts and every machine makes the same bytes.

use raxel::world::random::SplitMix64;

/// Width, height, and pictures of the shipped file.
pub(crate) const EXTENT: [usize; 3] = [64, 64, 32];

/// Where the random numbers of the shipped file start.
pub(crate) const SEED: u64 = 1;

/// Standard deviation of the repulsion, in pixels and in pictures.
const SIGMA: f64 = 1.9;

/// Beyond so many pixels or pictures there is none.
const REACH: isize = 8;

/// The value of each pixel of each picture: x first, then y, then time. Each of the 256 values occurs equally often, as far as their
/// number allows.
pub(crate) fn blue_noise(extent: [usize; 3], seed: u64) -> Vec<u8> {
    let count = extent.iter().product::<usize>();
    let mut ranks = vec![0; count];
    let initial = spread_out(scattered(extent, count / 10, seed));
    // The points of the initial pattern, from the one that is missed least: these have the lowest ranks.
    let mut pattern = initial.clone();
    for rank in (0..initial.points).rev() {
        let cluster = pattern.tightest_cluster();
        pattern.set(cluster, false);
        ranks[cluster] = rank;
    }
    // Then the largest voids, until there is none. Once most pixels are points, a large void is a tight cluster of voids.
    let mut pattern = initial;
    for rank in pattern.points..count {
        let void = pattern.largest_void();
        pattern.set(void, true);
        ranks[void] = rank;
    }
    ranks.into_iter().map(|rank| (rank * 256 / count) as u8).collect()
}

fn scattered(extent: [usize; 3], points: usize, seed: u64) -> Pattern {
    let mut pattern = Pattern::new(extent);
    let mut random = SplitMix64::new(seed);
    while pattern.points < points {
        let at = (random.bits() % pattern.is_point.len() as u64) as usize;
        if !pattern.is_point[at] {
            pattern.set(at, true);
        }
    }
    pattern
}

/// Moves points from tight clusters to large voids until that changes nothing.
fn spread_out(mut pattern: Pattern) -> Pattern {
    loop {
        let cluster = pattern.tightest_cluster();
        pattern.set(cluster, false);
        let void = pattern.largest_void();
        pattern.set(void, true);
        if void == cluster {
            return pattern;
        }
    }
}

/// Points on a torus, with the energy that they have at each place.
#[derive(Clone)]
struct Pattern {
    extent: [usize; 3],
    kernel: Vec<([isize; 3], u64)>,
    is_point: Vec<bool>,
    energy: Vec<u64>,
    points: usize,
    /// Tournaments over all places, as binary heaps without order: the winner is node 1, place i is leaf `leaves + i`.
    voids: Vec<u32>,
    clusters: Vec<u32>,
    leaves: usize,
}

const NOBODY: u32 = u32::MAX;

impl Pattern {
    fn new(extent: [usize; 3]) -> Self {
        let count = extent.iter().product::<usize>();
        let leaves = count.next_power_of_two();
        let mut pattern = Self {
            extent,
            kernel: kernel(extent),
            is_point: vec![false; count],
            energy: vec![0; count],
            points: 0,
            voids: vec![NOBODY; 2 * leaves],
            clusters: vec![NOBODY; 2 * leaves],
            leaves,
        };
        (0..count).for_each(|place| pattern.play(place));
        pattern
    }

    /// The place without a point that has the least energy.
    fn largest_void(&self) -> usize {
        self.voids[1] as usize
    }

    /// The point that has the most energy.
    fn tightest_cluster(&self) -> usize {
        self.clusters[1] as usize
    }

    fn set(&mut self, place: usize, point: bool) {
        self.is_point[place] = point;
        self.points = if point { self.points + 1 } else { self.points - 1 };
        let [width, height, _] = self.extent;
        let at = [place % width, place / width % height, place / (width * height)];
        for index in 0..self.kernel.len() {
            let (offset, energy) = self.kernel[index];
            let wrap = |axis: usize| (at[axis] as isize + offset[axis]).rem_euclid(self.extent[axis] as isize) as usize;
            let [x, y, z] = [wrap(0), wrap(1), wrap(2)];
            let other = (z * height + y) * width + x;
            self.energy[other] = if point { self.energy[other] + energy } else { self.energy[other] - energy };
            self.play(other);
        }
    }

    /// Plays the rounds of a place whose energy has changed. Of equals the lower index wins.
    fn play(&mut self, place: usize) {
        let (energy, leaves) = (&self.energy, self.leaves);
        let of = |place: u32| energy[place as usize];
        let leaf = |there: bool| if there { place as u32 } else { NOBODY };
        let less = |a: u32, b: u32| a != NOBODY && (b == NOBODY || (of(a), a) < (of(b), b));
        let more = |a: u32, b: u32| a != NOBODY && (b == NOBODY || of(a) > of(b) || of(a) == of(b) && a < b);
        climb(&mut self.voids, leaves + place, leaf(!self.is_point[place]), less);
        climb(&mut self.clusters, leaves + place, leaf(self.is_point[place]), more);
    }
}

fn climb(tree: &mut [u32], leaf: usize, value: u32, wins: impl Fn(u32, u32) -> bool) {
    tree[leaf] = value;
    let mut node = leaf / 2;
    while node > 0 {
        let (a, b) = (tree[2 * node], tree[2 * node + 1]);
        tree[node] = if wins(a, b) { a } else { b };
        node /= 2;
    }
}

/// Offsets with the energy of a point there.
fn kernel(extent: [usize; 3]) -> Vec<([isize; 3], u64)> {
    let energy =
        |squared: isize| ((-(squared as f64) / (2.0 * SIGMA * SIGMA)).exp() * f64::from(1 << 24)).round() as u64;
    // An axis shorter than the reach would meet itself from behind.
    let reach = extent.map(|side| REACH.min((side as isize - 1) / 2));
    let mut kernel = Vec::new();
    for y in -reach[1]..=reach[1] {
        for x in -reach[0]..=reach[0] {
            kernel.push(([x, y, 0], energy(x * x + y * y)));
        }
    }
    let in_time = (-reach[2]..=reach[2]).filter(|z| *z != 0);
    kernel.extend(in_time.map(|z| ([0, 0, z], energy(z * z))));
    kernel
}
