//! Draws who is near as skinned meshes, and who is far from records.

use crate::ThrongSystems;
use crate::appearance::{CrowdAppearance, FAR_JOINTS, FAR_WEIGHTS, rows};
use crate::crowd::{Crowd, CrowdMessage, Entered};
use crate::joints::{Joints, follow};
use bevy::asset::{RenderAssetUsages, embedded_asset};
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{MeshTag, MeshVertexBufferLayoutRef};
use bevy::pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline};
use bevy::prelude::*;
use bevy::render::render_resource::{AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError};
use bevy::render::renderer::RenderDevice;
use bevy::render::storage::ShaderBuffer;
use bevy::shader::ShaderRef;
use throng_runtime::characters::PoseInstance;

const SHADER: &str = "embedded://throng_bevy/far.wgsl";
/// Whoever stands, walks or lies is within this box about its root: half its size, and its centre (m).
const BOX_M: [Vec3; 2] = [Vec3::new(1.5, 1.5, 1.5), Vec3::new(0.0, 1.0, 0.0)];

/// Bevy's own material for bodies that are posed from records in the vertex shader.
pub type FarMaterial = ExtendedMaterial<StandardMaterial, FromRecords>;

/// Poses a body from its [`Instance`], whose number is the entity's `MeshTag`.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct FromRecords {
    /// Records by place (capacity).
    #[storage(100, read_only, visibility(vertex))]
    records: Handle<ShaderBuffer>,
    /// Matrices of all frame rows.
    #[storage(101, read_only, visibility(vertex))]
    rows: Handle<ShaderBuffer>,
}

impl MaterialExtension for FromRecords {
    fn vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn prepass_vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn deferred_vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        _: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let ours = [FAR_JOINTS.at_shader_location(10), FAR_WEIGHTS.at_shader_location(11)];
        let ours = layout.0.get_layout(&ours)?;
        descriptor.vertex.buffers[0].attributes.extend(ours.attributes);
        Ok(())
    }
}

/// What a crowd is drawn with.
#[derive(Component, Debug)]
pub struct Drawn {
    /// Of the bundle that it is made of.
    generation: u32,
    near: Handle<Mesh>,
    far: Handle<Mesh>,
    bind: Handle<SkinnedMeshInverseBindposes>,
    materials: Vec<(Handle<StandardMaterial>, Handle<FarMaterial>)>,
    records: Handle<ShaderBuffer>,
    rows: Handle<ShaderBuffer>,
}

/// Adds what draws.
pub fn build(app: &mut App) {
    embedded_asset!(app, "far.wgsl");
    app.add_plugins(MaterialPlugin::<FarMaterial>::default());
    app.add_systems(Update, (dress, show_near, show_far, upload).chain().after(follow).in_set(ThrongSystems::Show));
}

/// Makes meshes and buffers of a bundle that is new; handles stay.
fn dress(
    mut commands: Commands,
    mut crowds: Query<(Entity, &Crowd, &CrowdAppearance, Option<&mut Drawn>)>,
    device: Res<RenderDevice>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut binds: ResMut<Assets<SkinnedMeshInverseBindposes>>,
    mut buffers: ResMut<Assets<ShaderBuffer>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut far_materials: ResMut<Assets<FarMaterial>>,
    mut messages: MessageWriter<CrowdMessage>,
) {
    for (entity, crowd, look, drawn) in &mut crowds {
        let Some(live) = &crowd.live else { continue };
        let generation = live.generation;
        if drawn.as_ref().is_some_and(|drawn| drawn.generation == generation) {
            continue;
        }
        let most = device.limits().max_storage_buffer_binding_size;
        let made = look.meshes(&live.bundle).and_then(|meshes| {
            let rows = rows(&live.bundle).map_err(|e| e.to_string())?;
            match rows.len() as u64 <= most {
                true => Ok((meshes, rows)),
                false => Err(format!(
                    "its frame rows take {} bytes where the adapter takes {most} in one buffer; bake fewer clips",
                    rows.len()
                )),
            }
        });
        let ((near, far), rows) = match made {
            Ok(made) => made,
            Err(why) if drawn.is_some() => {
                // Said once: what there was is drawn on.
                drawn.into_iter().for_each(|mut drawn| drawn.generation = generation);
                error!("{entity}: {why}");
                messages.write(CrowdMessage::Failed { entity, why });
                continue;
            }
            Err(why) => {
                error!("{entity}: {why}");
                messages.write(CrowdMessage::Failed { entity, why });
                commands.entity(entity).remove::<CrowdAppearance>();
                continue;
            }
        };
        let rest = live.bundle.skeleton().rest_positions();
        let bind: Vec<Mat4> = rest.iter().map(|p| Mat4::from_translation(-Vec3::from_array(p.to_array()))).collect();
        let rows = ShaderBuffer::new(&rows, RenderAssetUsages::RENDER_WORLD);
        if let Some(mut drawn) = drawn {
            drawn.generation = generation;
            // They exist: this crowd holds their handles.
            _ = meshes.insert(&drawn.near, near);
            _ = meshes.insert(&drawn.far, far);
            _ = binds.insert(&drawn.bind, bind.into());
            _ = buffers.insert(&drawn.rows, rows);
            for (_, far) in &drawn.materials {
                if let Some(mut material) = far_materials.get_mut(far) {
                    // Changed by that: its bind group names the buffer that was.
                    material.extension.rows = drawn.rows.clone();
                }
            }
            continue;
        }
        let records = vec![0; crowd.capacity().max(1) * size_of::<PoseInstance>()];
        let records = buffers.add(ShaderBuffer::new(&records, RenderAssetUsages::default()));
        let rows = buffers.add(rows);
        let extension = FromRecords { records: records.clone(), rows: rows.clone() };
        let pair = |base: &StandardMaterial| {
            let far = ExtendedMaterial { base: base.clone(), extension: extension.clone() };
            (materials.add(base.clone()), far_materials.add(far))
        };
        let default_look = [StandardMaterial::default()];
        let all = if look.materials.is_empty() { &default_look[..] } else { &look.materials };
        commands.entity(entity).insert(Drawn {
            generation,
            near: meshes.add(near),
            far: meshes.add(far),
            bind: binds.add(SkinnedMeshInverseBindposes::from(bind)),
            materials: all.iter().map(pair).collect(),
            records,
            rows,
        });
    }
}

/// Who has joints now gets a skin, a child of the hips, and is drawn from its record no more.
fn show_near(mut commands: Commands, near: Query<(Entity, &Entered, &Joints), Added<Joints>>, crowds: Query<&Drawn>) {
    for (entity, entered, joints) in &near {
        let Ok(drawn) = crowds.get(entered.crowd) else { continue };
        let (material, _) = &drawn.materials[entered.id.index() % drawn.materials.len()];
        commands.entity(entity).remove::<Mesh3d>();
        commands.spawn((
            Mesh3d(drawn.near.clone()),
            MeshMaterial3d(material.clone()),
            SkinnedMesh { inverse_bindposes: drawn.bind.clone(), joints: joints.joints.to_vec() },
            (Aabb::from_min_max(-BOX_M[0], BOX_M[0]), NoAutoAabb),
            ChildOf(joints.joints[0]),
        ));
    }
}

/// Everybody else is drawn from records.
fn show_far(
    mut commands: Commands,
    far: Query<(Entity, &Entered), (Without<Mesh3d>, Without<Joints>)>,
    crowds: Query<&Drawn>,
) {
    for (entity, entered) in &far {
        let Ok(drawn) = crowds.get(entered.crowd) else { continue };
        let (_, material) = &drawn.materials[entered.id.index() % drawn.materials.len()];
        commands.entity(entity).insert((
            Mesh3d(drawn.far.clone()),
            MeshMaterial3d(material.clone()),
            MeshTag(entered.id.index),
            (Aabb::from_min_max(BOX_M[1] - BOX_M[0], BOX_M[1] + BOX_M[0]), NoAutoAabb),
        ));
    }
}

/// Records of this update, by place.
fn upload(crowds: Query<(&Crowd, &Drawn)>, mut buffers: ResMut<Assets<ShaderBuffer>>) {
    for (crowd, drawn) in &crowds {
        let (Some(group), Some(mut buffer)) = (crowd.character_group(), buffers.get_mut(&drawn.records)) else {
            continue;
        };
        let mut records = vec![PoseInstance::default(); crowd.capacity().max(1)];
        for (id, record) in group.ids().iter().zip(group.instances()) {
            records[id.index()] = *record;
        }
        buffer.data = Some(bytemuck::cast_slice(&records).to_vec());
    }
}
