//! The choice of the physical device and its reason: a pure function over the reported properties of the devices.

use std::fmt;

use ash::vk;

/// The reported properties of a device, as far as the choice depends on them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Place in the loader's list.
    pub index: usize,
    /// Name, e.g. `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub name: String,
    /// Kind.
    pub kind: DeviceKind,
    /// Vulkan version.
    pub version: Version,
    /// Needs of raxel that the device lacks, by Vulkan's names.
    pub missing: Vec<&'static str>,
    /// Bytes of device-local memory.
    pub memory: u64,
}

/// A version of Vulkan. They compare as versions do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the parts of a version")]
pub struct Version {
    pub major: u32,
    pub minor: u32,
    pub patch: u32,
}

impl Version {
    /// The version that Vulkan packs into one number.
    pub(crate) fn from_packed(packed: u32) -> Self {
        Self {
            major: vk::api_version_major(packed),
            minor: vk::api_version_minor(packed),
            patch: vk::api_version_patch(packed),
        }
    }
}

/// Kind of a device, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "each variant is the VkPhysicalDeviceType of its name")]
pub enum DeviceKind {
    Discrete,
    Integrated,
    Virtual,
    Other,
    Cpu,
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            DeviceKind::Discrete => "discrete GPU",
            DeviceKind::Integrated => "integrated GPU",
            DeviceKind::Virtual => "virtual GPU",
            DeviceKind::Other => "unknown kind of device",
            DeviceKind::Cpu => "software on the CPU",
        })
    }
}

/// The decision about one candidate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The candidate.
    pub candidate: Candidate,
    /// It is the one.
    pub chosen: bool,
    /// Why, in a few words.
    pub reason: String,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Candidate { index, name, kind, version, .. } = &self.candidate;
        let mark = if self.chosen { '*' } else { ' ' };
        write!(f, "{mark} {index}: {name} ({kind}, Vulkan {}.{}): {}", version.major, version.minor, self.reason)
    }
}

/// Judges every candidate. `wanted` is an index or a part of a name (case does not matter). At most one verdict is `chosen`: the
/// wanted one, else the best kind, then the largest memory, then the first in the loader's order.
pub fn choose(candidates: Vec<Candidate>, wanted: Option<&str>) -> Vec<Verdict> {
    let fits = |c: &Candidate| match wanted {
        Some(text) => match text.trim().parse::<usize>() {
            Ok(index) => c.index == index,
            Err(_) => c.name.to_lowercase().contains(&text.trim().to_lowercase()),
        },
        None => true,
    };
    let best = candidates
        .iter()
        .filter(|c| c.missing.is_empty() && fits(c))
        .min_by_key(|c| (c.kind, std::cmp::Reverse(c.memory), c.index))
        .cloned();
    let usable = candidates.iter().filter(|c| c.missing.is_empty()).count();
    candidates
        .into_iter()
        .map(|candidate| {
            let chosen = best.as_ref().is_some_and(|best| best.index == candidate.index);
            let reason = if !candidate.missing.is_empty() {
                format!("rejected, it lacks {}", candidate.missing.join(", "))
            } else if chosen {
                match wanted {
                    Some(text) => format!("chosen, asked for by `{text}`"),
                    None if usable == 1 => "chosen, the only suitable device".to_owned(),
                    None => "chosen, the best kind of device with the most memory".to_owned(),
                }
            } else if fits(&candidate) {
                match &best {
                    Some(best) if best.kind != candidate.kind => format!("not chosen, a {} is better", best.kind),
                    _ => "not chosen, another of its kind has more memory or comes first".to_owned(),
                }
            } else {
                format!("not chosen, `{}` was asked for", wanted.unwrap_or_default())
            };
            Verdict { candidate, chosen, reason }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(index: usize, name: &str, kind: DeviceKind, memory: u64) -> Candidate {
        Candidate {
            index,
            name: name.to_owned(),
            kind,
            version: Version { major: 1, minor: 3, patch: 0 },
            missing: Vec::new(),
            memory,
        }
    }

    fn chosen(verdicts: &[Verdict]) -> Option<usize> {
        let chosen: Vec<_> = verdicts.iter().filter(|v| v.chosen).map(|v| v.candidate.index).collect();
        assert!(chosen.len() <= 1, "{verdicts:?}");
        chosen.first().copied()
    }

    fn three() -> Vec<Candidate> {
        vec![
            device(0, "llvmpipe (LLVM 15.0.6, 256 bits)", DeviceKind::Cpu, 64 << 30),
            device(1, "Small", DeviceKind::Discrete, 4 << 30),
            device(2, "Large", DeviceKind::Discrete, 8 << 30),
        ]
    }

    #[test]
    fn the_best_kind_with_the_most_memory_wins() {
        let verdicts = choose(three(), None);
        assert_eq!(chosen(&verdicts), Some(2));
        assert_eq!(
            verdicts[0].to_string(),
            "  0: llvmpipe (LLVM 15.0.6, 256 bits) (software on the CPU, Vulkan 1.3): not chosen, a discrete GPU is better"
        );
        assert!(verdicts[2].to_string().starts_with("* 2: Large"));
    }

    #[test]
    fn a_name_or_an_index_overrides() {
        assert_eq!(chosen(&choose(three(), Some("LLVMPIPE"))), Some(0));
        assert_eq!(chosen(&choose(three(), Some("1"))), Some(1));
        assert_eq!(chosen(&choose(three(), Some("7"))), None);
        assert_eq!(chosen(&choose(three(), Some("radeon"))), None);
    }

    #[test]
    fn an_unsuitable_device_says_what_it_lacks() {
        let mut devices = three();
        devices[2].missing = vec!["synchronization2", "maintenance4"];
        let verdicts = choose(devices, None);
        assert_eq!(chosen(&verdicts), Some(1));
        assert_eq!(verdicts[2].reason, "rejected, it lacks synchronization2, maintenance4");
        assert_eq!(verdicts[1].reason, "chosen, the best kind of device with the most memory");
    }
}
