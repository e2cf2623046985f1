//! Decides when to retry a plan that the device refused. Memory may be free by then, but a try costs as much as a frame or more.

/// Most frames between two tries.
const MOST: u32 = 256;

/// Counts the frames until the next try: 0 at first, and twice as many after each refusal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Retry {
    wait: u32,
    left: Option<u32>,
}

impl Retry {
    /// The device has refused. True for the first time: then it is worth saying.
    pub(crate) fn refused(&mut self) -> bool {
        let first = self.left.is_none();
        self.left = Some(self.wait);
        self.wait = if first { 1 } else { (self.wait * 2).min(MOST) };
        first
    }

    /// Another frame begins. Whether it is time for another try.
    pub(crate) fn due(&mut self) -> bool {
        match &mut self.left {
            None => false,
            Some(0) => true,
            Some(left) => {
                *left -= 1;
                false
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_frame_tries_again_and_later_ones_ever_more_rarely() {
        let mut retry = Retry::default();
        assert!(!retry.due(), "nothing was refused");
        assert!(retry.refused());
        let mut tries = Vec::new();
        for frame in 0..600 {
            if retry.due() {
                tries.push(frame);
                assert!(!retry.refused(), "it is said once");
            }
        }
        assert_eq!(tries, [0, 2, 5, 10, 19, 36, 69, 134, 263, 520]);
    }
}
