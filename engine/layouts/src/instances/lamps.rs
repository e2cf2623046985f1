//! The lamps on instances: faces of models that give off light. Their places are those of the models, so the list stays the same while instances
//! move. The twin of `shaders/light/face_cache/instance_lamps.glsl`.

use raxel_world::Material;

use super::{InstanceModel, Instances};
use crate::lights::{Light, alias_table, lights_by, power};

/// Words of a quad.
const QUAD: usize = 4;

/// The emission of a model's materials, by its own palette.
pub(super) fn powers(model: &InstanceModel, palette: &[Material]) -> Vec<f32> {
    model.materials.iter().map(|of_world| palette.get(usize::from(*of_world)).map_or(0.0, power)).collect()
}

/// The faces of a model that give off light and that no other voxel of it covers.
pub(super) fn of_model(model: &InstanceModel, palette: &[Material]) -> Vec<Light> {
    lights_by(&model.voxels, &powers(model, palette))
}

/// Lamps of all instances.
#[derive(Clone, Debug, Default)]
pub(super) struct Lamps {
    /// Instances with lamps.
    pub count: u32,
    /// The list: a quad with the sum of all powers; two quads for each instance with lamps, with its faces and its entry of the draw table;
    /// two for each face of a model, with its place and its entry of the draw table.
    pub words: Vec<u32>,
    /// The power of each model, 0 without a lamp.
    pub of_models: Vec<f32>,
}

impl Lamps {
    /// `corners` are the smallest corners of the cubes of the models, in their own coordinates.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a list of lamps has 32-bit floats and is addressed in 32 bits"
    )]
    pub(crate) fn new(instances: &Instances, palette: &[Material], corners: &[[i32; 3]]) -> Self {
        let faces: Vec<Vec<Light>> = instances.models.iter().map(|model| of_model(model, palette)).collect();
        // Not `sum`, which is −0 for a model without a lamp.
        let sums: Vec<f64> =
            faces.iter().map(|faces| faces.iter().fold(0.0, |sum, face| sum + f64::from(face.power))).collect();
        let lit: Vec<usize> = (0..instances.list.len()).filter(|i| sums[instances.list[*i].model] > 0.0).collect();
        let of_models = sums.iter().map(|sum| *sum as f32).collect();
        if lit.is_empty() {
            return Self { of_models, ..Self::default() };
        }
        let powers: Vec<f64> = lit.iter().map(|i| sums[instances.list[*i].model]).collect();
        let total: f64 = powers.iter().sum();
        let mut words = vec![(total as f32).to_bits(), 0, 0, 0];
        // Faces stand behind all instances.
        let mut at = 1 + 2 * lit.len();
        let mut first = Vec::new();
        for faces in &faces {
            first.push(at);
            at += 2 * faces.len();
        }
        for (i, draw) in lit.iter().zip(alias_table(&powers, total)) {
            let model = instances.list[*i].model;
            words.extend([*i as u32, first[model] as u32, faces[model].len() as u32, 0]);
            words.extend([draw.threshold.to_bits(), draw.alias, 0, 0]);
        }
        for ((faces, sum), corner) in faces.iter().zip(&sums).zip(corners) {
            let powers: Vec<f64> = faces.iter().map(|face| f64::from(face.power)).collect();
            for (face, draw) in faces.iter().zip(alias_table(&powers, *sum)) {
                let place = face.voxel.to_array().into_iter().zip(corner);
                words.extend(place.map(|(v, corner)| v.wrapping_sub(*corner).cast_unsigned()));
                words.push(u32::from(face.material) | face.face << 16);
                words.extend([draw.threshold.to_bits(), draw.alias, 0, 0]);
            }
        }
        debug_assert_eq!(words.len(), QUAD * at, "the places of all faces");
        Self { count: lit.len() as u32, words, of_models }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::IVec3;
    use raxel_world::World;

    use super::*;
    use crate::instances::{Instance, Pose};

    /// A lantern of two voxels on a post, and a post without one; the palette of the world has the lamp in another place than the model.
    fn fair() -> (Instances, Vec<Material>) {
        let lamp = |emission| Material { emission, ..Material::matt("lamp", [1.0; 3]) };
        let own = vec![Material::air(), Material::matt("post", [0.5; 3]), Material::matt("lamp", [1.0; 3])];
        let voxels = |top: u16| {
            World::from_voxels(
                own.clone(),
                [(IVec3::new(5, 0, 0), 1), (IVec3::new(5, 1, 0), top), (IVec3::new(5, 2, 0), top)],
            )
        };
        let model = |top| super::InstanceModel { voxels: Arc::new(voxels(top)), materials: Arc::from([0, 1, 3]) };
        let pose = Pose::new([0.0; 3], [0.0; 3]);
        let one = |model| Instance { name: None, model, anchor: [0; 3], pose, motions: Vec::new() };
        let instances = Instances { models: vec![model(1), model(2)], list: vec![one(1), one(0), one(1)] };
        (instances, vec![Material::air(), Material::matt("post", [0.5; 3]), lamp(7.0), lamp(2.0)])
    }

    #[test]
    fn bare_faces_of_models_are_listed_once_and_instances_that_have_them() {
        let (instances, palette) = fair();
        let lamps = Lamps::new(&instances, &palette, &[[4, 0, 0], [4, 0, 0]]);
        assert_eq!(lamps.count, 2);
        // Four sides of each voxel and the top of the upper one, by the emission of the world.
        assert_eq!(lamps.of_models, [0.0, 18.0]);
        assert_eq!(lamps.words[0], 36.0_f32.to_bits());
        let quad = |at: usize| &lamps.words[4 * at..4 * at + 4];
        assert_eq!((quad(1), quad(3)), (&[0, 5, 9, 0][..], &[2, 5, 9, 0][..]));
        assert_eq!(lamps.words.len(), 4 * (5 + 2 * 9));
        assert_eq!(quad(5), [1, 1, 0, 2]);
        assert!(instances.has_emission(&palette) && !instances.has_emission(&palette[..3]));
        assert_eq!(Lamps::new(&instances, &[], &[[0; 3]; 2]).count, 0);
    }
}
