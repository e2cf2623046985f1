//! Timestamps.

use std::sync::Arc;

use ash::vk;

use crate::device::Device;
use crate::result::{Named, Result};
use crate::retire::Dead;

/// The clock that a queue takes timestamps of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueueClock {
    /// Nanoseconds of a tick.
    pub period: f32,
    /// Bits of a timestamp, 36 to 64. After the largest one the clock begins again at 0: with 36 bits of 52 ns, every hour.
    pub bits: u32,
}

impl QueueClock {
    /// Nanoseconds from one timestamp to another that is taken at most half a turn of the clock away; negative if that one is earlier.
    pub fn nanoseconds(&self, from: u64, to: u64) -> f64 {
        let unused = u64::BITS - self.bits.clamp(1, u64::BITS);
        let ticks = (to.wrapping_sub(from) << unused).cast_signed() >> unused;
        ticks as f64 * f64::from(self.period)
    }
}

/// A pool of timestamps.
pub struct Timestamps {
    pub(crate) raw: vk::QueryPool,
    device: Arc<Device>,
    count: u32,
}

impl Timestamps {
    /// Makes a pool; `None` when the queue has no timestamps.
    pub fn new(device: &Arc<Device>, name: &str, count: u32) -> Result<Option<Timestamps>> {
        if device.capabilities().clock.is_none() || count == 0 {
            return Ok(None);
        }
        let create = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        // SAFETY: plain data.
        let raw = unsafe { device.raw.create_query_pool(&create, None) }.named("vkCreateQueryPool")?;
        device.name(raw, name);
        Ok(Some(Timestamps { raw, device: device.clone(), count }))
    }

    /// Number of timestamps.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Reads timestamps from the first on, without waiting: ticks, and 0 or 1 for whether the tick was written.
    pub fn read(&self, into: &mut [[u64; 2]]) -> Result<()> {
        let count = into.len().min(self.count as usize);
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
        // SAFETY: at most `count` queries are read; each element holds a tick and its availability.
        match unsafe { self.device.raw.get_query_pool_results(self.raw, 0, &mut into[..count], flags) } {
            Ok(()) | Err(ash::vk::Result::NOT_READY) => Ok(()),
            result => self.device.watch(result.named("vkGetQueryPoolResults")),
        }
    }
}

impl Timestamps {
    /// Whether the device has taken a time since the pool was made ready. Does not wait; `None` when the device does not answer.
    pub fn is_taken(&self, index: u32) -> Option<bool> {
        let mut answer = [[0_u64; 2]];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
        if index >= self.count {
            return None;
        }
        // SAFETY: the index is within the pool; the element holds a tick and its availability.
        match unsafe { self.device.raw.get_query_pool_results(self.raw, index, &mut answer, flags) } {
            Ok(()) | Err(ash::vk::Result::NOT_READY) => Some(answer[0][1] != 0),
            Err(_) => None,
        }
    }
}

impl Drop for Timestamps {
    fn drop(&mut self) {
        self.device.retire(Dead::QueryPool(self.raw));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "small whole numbers are exact")]
    fn a_clock_that_begins_again_measures_on() {
        let last = (1_u64 << 36) - 1;
        let intel = QueueClock { period: 2.0, bits: 36 };
        for (from, to, nanoseconds) in [(7, 12, 10.0), (last - 1, 3, 10.0), (3, last - 1, -10.0), (5, 5, 0.0)] {
            assert_eq!(intel.nanoseconds(from, to), nanoseconds, "{from} to {to}");
        }
        assert_eq!(QueueClock { period: 1.0, bits: 64 }.nanoseconds(u64::MAX, 1), 2.0);
    }
}
