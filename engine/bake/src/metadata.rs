//! The JSON documents of a store: a group with what raxel reads, and an array for each level of detail, as any reader of Zarr v3 and
//! of OME-Zarr expects them.

use raxel_world::{MAX_LEVEL, MAX_MATERIALS, Material, cell_edge};
use serde::{Deserialize, Serialize};

use crate::plan::{BakedLevel, CHUNK, Plan};
use crate::shard::ZSTD_LEVEL;

/// The version of the attributes under `raxel`, and of the contents of a shard. Format 1 had no checksum here, and no seals.
const FORMAT: u32 = 2;
/// The object of the group.
pub(crate) const GROUP: &str = "zarr.json";

/// The attributes of a store that raxel reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Baked {
    /// [`FORMAT`].
    pub(crate) format: u32,
    /// Name of the world.
    pub(crate) world: String,
    /// Hash of everything that the voxels are made from.
    pub(crate) fingerprint: String,
    /// Cells along an edge of a shard.
    pub(crate) edge: u32,
    /// Level 0 first.
    pub(crate) levels: Vec<Level>,
    /// By palette index; 0 is air.
    pub(crate) materials: Vec<Material>,
}

/// A level of detail.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Level {
    /// Voxels along a cell.
    pub(crate) cell: i64,
    /// The cell of the world, in cells of this level, that the array has at index 0: x, y, z.
    pub(crate) origin: [i64; 3],
    /// Shards along x, y, z.
    pub(crate) shards: [u32; 3],
}

/// A group document that is not one of these.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unreadable {
    /// It is no JSON, or lacks something.
    #[error("it is not a world that raxel has baked: {0}")]
    Wrong(String),
    /// A later raxel wrote it.
    #[error("it has format {found}, and this raxel reads formats up to {FORMAT}")]
    Newer {
        /// Its format.
        found: u32,
    },
    /// An earlier raxel wrote it.
    #[error("it has format {found}, in which damage could pass unnoticed: bake the world again to another place")]
    Older {
        /// Its format.
        found: u32,
    },
    /// It has another checksum than is written in it.
    #[error("it is damaged: it has the checksum {found}, and {written} is written in it")]
    Damaged {
        /// Of the document.
        found: String,
        /// The checksum in the document.
        written: String,
    },
}

impl Baked {
    pub(crate) fn of(plan: &Plan) -> Self {
        let level = |level: &BakedLevel| Level {
            cell: cell_edge(level.level),
            origin: level.origin(plan.edge),
            shards: level.shards,
        };
        Self {
            format: FORMAT,
            world: plan.name.clone(),
            fingerprint: plan.fingerprint.clone(),
            edge: plan.edge,
            levels: plan.levels().iter().map(level).collect(),
            materials: plan.materials.clone(),
        }
    }

    /// Reads the document of a group.
    pub(crate) fn read(document: &[u8]) -> Result<Self, Unreadable> {
        let wrong = |reason: &str| Unreadable::Wrong(reason.to_owned());
        let value: serde_json::Value =
            serde_json::from_slice(document).map_err(|error| Unreadable::Wrong(error.to_string()))?;
        let attributes = value.pointer("/attributes/raxel").ok_or_else(|| wrong("it has no attribute `raxel`"))?;
        let format = attributes.get("format").and_then(serde_json::Value::as_u64);
        let format = format.ok_or_else(|| wrong("its attribute `raxel` has no `format`"))?;
        match u32::try_from(format).unwrap_or(u32::MAX) {
            found if found > FORMAT => return Err(Unreadable::Newer { found }),
            found if found < FORMAT => return Err(Unreadable::Older { found }),
            _ => {}
        }
        let baked = Self::deserialize(attributes).map_err(|error| Unreadable::Wrong(error.to_string()))?;
        let written = attributes.get("checksum").and_then(serde_json::Value::as_str);
        let written = written.ok_or_else(|| wrong("its attribute `raxel` has no `checksum`"))?.to_owned();
        let found = baked.checksum();
        if found != written {
            return Err(Unreadable::Damaged { found, written });
        }
        if baked.edge == 0 || !baked.edge.is_multiple_of(CHUNK) || baked.edge > crate::plan::MOST_EDGE {
            return Err(Unreadable::Wrong(format!("shards of {} cells", baked.edge)));
        }
        if baked.materials.is_empty() || baked.materials.len() > MAX_MATERIALS + 1 {
            return Err(Unreadable::Wrong(format!("{} materials", baked.materials.len())));
        }
        if baked.levels.is_empty() || baked.levels.len() > MAX_LEVEL as usize + 1 {
            return Err(Unreadable::Wrong(format!("{} levels of detail", baked.levels.len())));
        }
        let edge = i64::from(baked.edge);
        for (index, level) in (0..).zip(&baked.levels) {
            let fits = |axis: usize| {
                let end = level.origin[axis].checked_add(i64::from(level.shards[axis]) * edge);
                level.origin[axis] % edge == 0
                    && level.origin[axis] >= -(1 << 32)
                    && end.is_some_and(|end| end <= 1 << 32)
            };
            if level.cell != cell_edge(index) || !(0..3).all(fits) {
                return Err(Unreadable::Wrong(format!(
                    "level {index} with an origin, an extent or a cell size that no bake writes"
                )));
            }
        }
        Ok(baked)
    }

    /// A CRC-32C of all of it. It covers values, not the document: other programs may write the document again, with other spaces or in another
    /// order.
    fn checksum(&self) -> String {
        let values = serde_json::to_vec(self).expect(PLAIN);
        format!("{:08x}", crc32c::crc32c(&values))
    }

    /// The levels as they are planned.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "`read` refuses levels that begin before −2³² cells, and a shard has at least 64 along an edge"
    )]
    pub(crate) fn baked_levels(&self) -> Vec<BakedLevel> {
        let edge = i64::from(self.edge);
        let levels = (0..).zip(&self.levels);
        levels
            .map(|(level, of)| BakedLevel { level, first: of.origin.map(|c| (c / edge) as i32), shards: of.shards })
            .collect()
    }
}

/// Every document of a store with its key, the group first. Keys of JSON objects are in the order of the fields here, so that the bytes
/// are the same wherever they are made.
pub(crate) fn documents(plan: &Plan) -> Vec<(String, Vec<u8>)> {
    let mut documents = vec![(GROUP.to_owned(), group(Baked::of(plan), Ome::of(plan)))];
    documents
        .extend(plan.levels().iter().map(|level| (format!("{}/zarr.json", level.level), bytes(&array(plan, level)))));
    documents
}

fn group(baked: Baked, ome: Ome) -> Vec<u8> {
    let raxel = Checked { checksum: baked.checksum(), baked };
    bytes(&Group { zarr_format: 3, node_type: "group", attributes: GroupAttributes { raxel, ome } })
}

const PLAIN: &str = "numbers, texts and lists of them are JSON";

fn bytes(document: &impl Serialize) -> Vec<u8> {
    let mut bytes = serde_json::to_vec_pretty(document).expect(PLAIN);
    bytes.push(b'\n');
    bytes
}

#[derive(Serialize)]
struct Group {
    zarr_format: u32,
    node_type: &'static str,
    attributes: GroupAttributes,
}

#[derive(Serialize)]
struct GroupAttributes {
    raxel: Checked,
    ome: Ome,
}

/// The attributes with their checksum.
#[derive(Serialize)]
struct Checked {
    #[serde(flatten)]
    baked: Baked,
    /// [`Baked::checksum`].
    checksum: String,
}

/// OME-Zarr 0.5: where the cells of each level are, in voxels of the world.
#[derive(Serialize)]
struct Ome {
    version: &'static str,
    multiscales: [Multiscale; 1],
}

#[derive(Serialize)]
struct Multiscale {
    name: String,
    axes: [Axis; 3],
    datasets: Vec<Dataset>,
}

#[derive(Serialize)]
struct Axis {
    name: &'static str,
    r#type: &'static str,
}

#[derive(Serialize)]
struct Dataset {
    path: String,
    #[serde(rename = "coordinateTransformations")]
    transformations: [Transformation; 2],
}

#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Transformation {
    Scale { scale: [f64; 3] },
    Translation { translation: [f64; 3] },
}

impl Ome {
    fn of(plan: &Plan) -> Self {
        let dataset = |level: &BakedLevel| {
            let cell = cell_edge(level.level) as f64;
            let [x, y, z] = level.origin(plan.edge).map(|c| (c as f64 + 0.5) * cell);
            Dataset {
                path: level.level.to_string(),
                transformations: [
                    Transformation::Scale { scale: [cell; 3] },
                    // The centre of the first cell.
                    Transformation::Translation { translation: [z, y, x] },
                ],
            }
        };
        Self {
            version: "0.5",
            multiscales: [Multiscale {
                name: plan.name.clone(),
                axes: AXES.map(|name| Axis { name, r#type: "space" }),
                datasets: plan.levels().iter().map(dataset).collect(),
            }],
        }
    }
}

/// Dimensions of the arrays, the slowest first.
const AXES: [&str; 3] = ["z", "y", "x"];

#[derive(Serialize)]
struct Array {
    zarr_format: u32,
    node_type: &'static str,
    shape: [u64; 3],
    data_type: &'static str,
    chunk_grid: Named<ChunkShape>,
    chunk_key_encoding: Named<Separator>,
    fill_value: u16,
    codecs: [Named<Sharding>; 1],
    dimension_names: [&'static str; 3],
    attributes: ArrayAttributes,
}

/// A named configuration of Zarr.
#[derive(Serialize)]
struct Named<T> {
    name: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    configuration: Option<T>,
}

impl<T> Named<T> {
    const fn new(name: &'static str, configuration: T) -> Self {
        Self { name, configuration: Some(configuration) }
    }
}

#[derive(Serialize)]
struct ChunkShape {
    chunk_shape: [u32; 3],
}

#[derive(Serialize)]
struct Separator {
    separator: &'static str,
}

#[derive(Serialize)]
struct Sharding {
    chunk_shape: [u32; 3],
    codecs: [Named<Codec>; 3],
    index_codecs: [Named<Codec>; 2],
    index_location: &'static str,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Codec {
    Bytes { endian: &'static str },
    Zstd { level: i32, checksum: bool },
}

#[derive(Serialize)]
struct ArrayAttributes {
    raxel: Level,
}

fn array(plan: &Plan, level: &BakedLevel) -> Array {
    let little = || Named::new("bytes", Codec::Bytes { endian: "little" });
    let crc = || Named { name: "crc32c", configuration: None };
    let zstd = Named::new("zstd", Codec::Zstd { level: ZSTD_LEVEL, checksum: false });
    let [x, y, z] = level.shards.map(|count| u64::from(count) * u64::from(plan.edge));
    Array {
        zarr_format: 3,
        node_type: "array",
        shape: [z, y, x],
        data_type: "uint16",
        chunk_grid: Named::new("regular", ChunkShape { chunk_shape: [plan.edge; 3] }),
        chunk_key_encoding: Named::new("default", Separator { separator: "/" }),
        fill_value: 0,
        codecs: [Named::new(
            "sharding_indexed",
            Sharding {
                chunk_shape: [CHUNK; 3],
                codecs: [little(), zstd, crc()],
                index_codecs: [little(), crc()],
                index_location: "end",
            },
        )],
        dimension_names: AXES,
        attributes: ArrayAttributes {
            raxel: Level { cell: cell_edge(level.level), origin: level.origin(plan.edge), shards: level.shards },
        },
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Not as _;

    use raxel_world::Bounds;

    use super::*;

    fn plan() -> Plan {
        let materials = vec![Material::air(), Material::matt("stone", [0.1, 0.25, 0.7])];
        let region = Bounds { min: [-70, 0, 0], max: [70, 64, 10] };
        Plan::new("hill", "abc", materials, region, 64, 2).unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let plan = plan();
        let documents = documents(&plan);
        let names: Vec<&str> = documents.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["zarr.json", "0/zarr.json", "1/zarr.json"]);
        let baked = Baked::read(&documents[0].1).unwrap();
        assert_eq!(baked, Baked::of(&plan));
        assert_eq!(baked.baked_levels(), plan.levels());
        let array: serde_json::Value = serde_json::from_slice(&documents[1].1).unwrap();
        assert_eq!(array["shape"], serde_json::json!([64, 64, 256]));
        assert_eq!(array["attributes"]["raxel"]["origin"], serde_json::json!([-128, 0, 0]));
        let sharding = &array["codecs"][0]["configuration"];
        assert_eq!(sharding["codecs"][2], serde_json::json!({ "name": "crc32c" }));
    }

    #[test]
    fn documents_of_others_are_refused() {
        let plan = plan();
        let good = String::from_utf8(documents(&plan)[0].1.clone()).unwrap();
        let refused = |text: &str| Baked::read(text.as_bytes()).unwrap_err().to_string();
        assert!(refused(&good[..good.len() / 2]).contains("EOF"), "{}", refused(&good[..good.len() / 2]));
        assert!(refused("{}").contains("no attribute `raxel`"));
        assert!(refused(&good.replace("\"format\": 2", "\"format\": 9")).contains("it has format 9"));
        assert!(refused(&good.replace("\"format\": 2", "\"format\": 1")).contains("bake the world again"));
        for (from, to) in [("\"checksum\"", "\"chucksum\""), ("\"materials\"", "\"stuff\"")] {
            refused(&good.replacen(from, to, 1));
        }
        // Those that are whole, and still no plan of a world.
        let wrong: [fn(&mut Baked); 6] = [
            |baked| baked.edge = 63,
            |baked| baked.edge = 128,
            |baked| baked.levels[1].cell = 3,
            |baked| baked.levels[0].origin[1] = i64::MIN,
            |baked| baked.levels.clear(),
            |baked| baked.materials.clear(),
        ];
        for (case, change) in wrong.into_iter().enumerate() {
            let mut baked = Baked::of(&plan);
            change(&mut baked);
            let error = Baked::read(&group(baked, Ome::of(&plan))).unwrap_err();
            assert!(matches!(error, Unreadable::Wrong(_)), "{case}: {error}");
        }
    }

    #[test]
    fn damage_of_any_byte_is_told_or_changes_nothing() {
        let plan = plan();
        let good = documents(&plan)[0].1.clone();
        let whole = Baked::of(&plan);
        for at in 0..good.len() {
            for bit in 0..8 {
                let mut damaged = good.clone();
                damaged[at] ^= 1 << bit;
                assert!(Baked::read(&damaged).is_ok_and(|found| found != whole).not(), "bit {bit} of byte {at}");
            }
            // The last byte ends the line.
            assert_eq!(Baked::read(&good[..at]).is_err(), at < good.len() - 1, "{at} bytes");
        }
        // Another program writes it with other spaces.
        let value: serde_json::Value = serde_json::from_slice(&good).unwrap();
        assert_eq!(Baked::read(value.to_string().as_bytes()), Ok(whole));
    }
}
