//! The subgroups of compute pipelines, and their consequence for packets of rays.

use std::fmt;

use ash::vk;

use crate::device::Capabilities;

/// How a device traces the rays of a camera (`<raxel/packet.glsl>`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Packets {
    /// In packets, by subgroups of 32, which every pipeline has.
    Own,
    /// In packets, by subgroups of 32, which a pipeline asks for. The least and the largest size that the device can make.
    Asked([u32; 2]),
    /// In packets, by one half of subgroups of 64.
    Halves,
    /// One by one: the needs of packets that the device lacks, and the size of its subgroups.
    None(Vec<&'static str>, u32),
}

impl fmt::Display for Packets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Packets::Own => write!(f, "in packets of 16 × 16, by subgroups of 32"),
            Packets::Asked([least, most]) => {
                write!(f, "in packets of 16 × 16, by subgroups of 32, out of sizes from {least} to {most}")
            }
            Packets::Halves => write!(f, "in packets of 16 × 16, by half of each subgroup of 64"),
            Packets::None(lacks, size) => {
                write!(f, "one by one: packets need {}, and this device has subgroups of {size}", lacks.join(", "))
            }
        }
    }
}

impl Capabilities {
    /// Whether a compute pipeline can ask for subgroups of that size.
    pub fn asks_for_subgroups_of(&self, size: u32) -> bool {
        size.is_power_of_two() && self.subgroup_sizes.is_some_and(|[least, most]| (least..=most).contains(&size))
    }

    /// How the rays of a camera are traced, in passes with `subgroup = 32`.
    pub fn packets(&self) -> Packets {
        let basic = self.subgroup_operations.contains(vk::SubgroupFeatureFlags::BASIC);
        let asked = self.subgroup_sizes.filter(|_| self.asks_for_subgroups_of(32));
        let needs = [
            (asked.is_some() || [32, 64].contains(&self.subgroup_size), "subgroups of 32 or 64"),
            (basic, "subgroup operations in compute shaders"),
            (self.plain_ballots, "`VK_EXT_shader_subgroup_ballot` and `VK_EXT_shader_subgroup_vote`"),
            (self.int64, "64-bit integers"),
        ];
        let lacks: Vec<_> = needs.into_iter().filter(|(has, _)| !has).map(|(_, what)| what).collect();
        match asked {
            _ if !lacks.is_empty() => Packets::None(lacks, self.subgroup_size),
            Some([least, most]) if least < most => Packets::Asked([least, most]),
            None if self.subgroup_size == 64 => Packets::Halves,
            _ => Packets::Own,
        }
    }

    /// Whether the device has the features for packets of rays (`<raxel/packet.glsl>`).
    pub fn traces_packets(&self) -> bool {
        !matches!(self.packets(), Packets::None(..))
    }

    /// Whether shaders may use the ballots and votes of `GL_ARB_shader_ballot` and `GL_ARB_shader_group_vote`, in subgroups of 32 at most, in a
    /// pass with `subgroup = 32`.
    pub fn has_plain_ballots(&self) -> bool {
        let basic = self.subgroup_operations.contains(vk::SubgroupFeatureFlags::BASIC);
        let narrow = self.subgroup_size <= 32 || self.asks_for_subgroups_of(32);
        basic && self.plain_ballots && self.int64 && narrow
    }
}

/// The sizes of subgroups that a compute pipeline can ask for with any workgroup.
pub(crate) fn sizes(
    sizes: &vk::PhysicalDeviceSubgroupSizeControlProperties<'_>,
    limits: &vk::PhysicalDeviceLimits,
) -> Option<[u32; 2]> {
    // A workgroup has a limit of subgroups; the smallest must still cover the largest workgroup.
    let invocations = limits.max_compute_work_group_invocations;
    let covers = |size: &u32| size.saturating_mul(sizes.max_compute_workgroup_subgroups) >= invocations;
    let range = sizes.min_subgroup_size..=sizes.max_subgroup_size;
    let mut able = (0..u32::BITS).map(|log2| 1 << log2).filter(|size| range.contains(size) && covers(size));
    let least = able.next()?;
    let there = sizes.required_subgroup_size_stages.contains(vk::ShaderStageFlags::COMPUTE);
    there.then(|| [least, able.next_back().unwrap_or(least)])
}
