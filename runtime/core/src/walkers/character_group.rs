//! Walkers as a character group: they enter, leave, take orders, are saved and loaded.

use super::{Control, WalkerActivity, WalkerStart, Walkers, WalkersState, config};
use crate::body::{BlockBefore, BodyEvent, BodyEventKind, Lanewise, MovedBody, NO_ROW};
use crate::character_group::{AdoptReport, CharacterGroup, OrderStatus, PosedBodies};
use crate::{bundle::Bundle, planar::Planar, skeleton::NUM_JOINTS, walkers::block::WalkerBlock};
use throng_base::{Error, Executor, Id, Result, SnapshotKind, limits::STEP_S, simd::LANES};

impl CharacterGroup for Walkers {
    type Start = WalkerStart;
    type Order = Control;
    type Event = BodyEvent;

    /// # Errors
    /// [`Error::Index`] for a body that does not exist, [`Error::Value`] for a number out of range, [`Error::Full`].
    fn spawn(&mut self, start: WalkerStart) -> Result<Id> {
        start.check(self.skeletons.len())?;
        let id = self.state.roster.add_id()?;
        self.state.bodies.push(start.body as u32);
        self.state.orders.push(Control::default());
        self.state.ordered.push(false);
        self.state.acts.push(WalkerActivity::default());
        self.resize();
        let row = self.len() - 1;
        let (block, lane) = (&mut self.state.blocks[row / LANES], row % LANES);
        block.copy_lane(lane, &WalkerBlock::ZERO, 0);
        block.place_root(lane, start.root);
        block.phase[lane] = start.phase - start.phase.floor();
        self.put_body(row);
        self.pose_rows(row..row + 1);
        Ok(id)
    }

    fn despawn(&mut self, id: Id) -> Result<()> {
        let (row, last) = self.state.roster.remove_id(id)?;
        self.state.bodies.swap_remove(row);
        self.state.orders.swap_remove(row);
        self.state.ordered.swap_remove(row);
        self.state.acts.swap_remove(row);
        let from = self.state.blocks[last / LANES];
        self.state.blocks[row / LANES].copy_lane(row % LANES, &from, last % LANES);
        self.state.blocks[last / LANES].copy_lane(last % LANES, &WalkerBlock::ZERO, 0);
        let stride = self.space.stride();
        self.roots.swap_remove(row);
        self.model.swap_remove(row);
        if self.config.instances {
            self.instances.swap_remove(row);
        }
        self.weights.copy_within(last * stride..(last + 1) * stride, row * stride);
        if self.config.local_transforms {
            self.locals.copy_within(last * NUM_JOINTS..(last + 1) * NUM_JOINTS, row * NUM_JOINTS);
        }
        self.resize();
        if row < last {
            self.put_body(row);
        }
        if let Some(body) = self.bodies.get_mut(last / LANES) {
            // Free lanes are alike however they became free, and so are snapshots of them.
            body.set_body(last % LANES, self.space.skeleton(), self.space.skeleton());
        }
        Ok(())
    }

    fn place(&mut self, id: Id, root: Planar) -> Result<()> {
        let row = self.row(id)?;
        config::check_root(Some(id), root)?;
        self.state.blocks[row / LANES].place_root(row % LANES, root);
        self.state.orders[row].position = None;
        self.state.acts[row] = WalkerActivity::default();
        self.pose_rows(row..row + 1);
        Ok(())
    }

    fn order(&mut self, id: Id, order: Control) -> Result<()> {
        let row = self.row(id)?;
        self.check_order(id, &order)?;
        self.state.orders[row] = order;
        self.state.ordered[row] = true;
        Ok(())
    }

    fn step(&mut self, dt_s: f32, run: &dyn Executor) -> Result<()> {
        STEP_S.check("dt_s", None, dt_s)?;
        let activities = self.space.activities();
        self.events.clear(dt_s * activities.rows.rate_hz);
        for (block, acts) in self.state.blocks.iter().zip(self.state.acts.chunks(LANES)) {
            let mut rows = [NO_ROW; LANES];
            for (row, act) in rows.iter_mut().zip(acts) {
                *row = act.acting.row(activities);
            }
            // The first pose of a walker is no step of its feet.
            let seen = std::array::from_fn(|lane| if block.placed[lane] > 0.0 { block.body.seen[lane] } else { 0.0 });
            self.events.note_before(BlockBefore { contacts: block.contacts, seen, rows });
        }
        self.advance(dt_s, run);
        let (ids, activities) = (self.state.roster.ids(), self.space.activities());
        for (b, (block, acts)) in self.state.blocks.iter().zip(self.state.acts.chunks(LANES)).enumerate() {
            let (body, swing) = (&self.bodies[b], &block.body.swing);
            for (lane, act) in acts.iter().enumerate() {
                let row = b * LANES + lane;
                if self.events.has_changed(row, block.contacts[lane], swing) {
                    let of = MovedBody { body, root: self.roots[row], model: &self.model[row], swing };
                    self.events.add_contacts(row, ids[row], block.contacts[lane], &of);
                }
                self.events.add_tags(row, ids[row], &activities.rows, act.acting.row(activities));
                if act.has_ended {
                    self.events.add(ids[row], BodyEvent::new(BodyEventKind::Performed, 0));
                }
            }
        }
        Ok(())
    }

    /// [`OrderStatus::Arrived`] once it has an order: a walker is always on its trajectory.
    fn status(&self, id: Id) -> Result<OrderStatus> {
        let is_ordered = self.state.ordered[self.row(id)?];
        Ok(if is_ordered { OrderStatus::Arrived } else { OrderStatus::Idle })
    }

    fn events(&self) -> &[(Id, BodyEvent)] {
        self.events.get()
    }

    fn bodies(&self) -> PosedBodies<'_> {
        PosedBodies { ids: self.state.roster.ids(), roots: &self.roots, model: &self.model }
    }

    fn save(&self, out: &mut Vec<u8>) {
        let mut kept = self.state.clone();
        kept.clear_free_lanes();
        self.kind().write(&kept, out);
    }

    fn load(&mut self, bytes: &[u8]) -> Result<()> {
        let kept: WalkersState = self.kind().read_all(bytes)?;
        let refuse = |why: &str| Err(Error::Snapshot { what: "walkers", why: why.into() });
        let n = kept.roster.ids().len();
        let lengths = [kept.bodies.len(), kept.orders.len(), kept.ordered.len(), kept.acts.len()];
        let has_bodies = kept.bodies.iter().all(|&body| (body as usize) < self.skeletons.len());
        if lengths != [n; 4] || kept.blocks.len() != n.div_ceil(LANES) || !has_bodies {
            return refuse("its rows do not fit together; it is damaged");
        }
        let can_be = |row: usize, id: Id| {
            let act = &kept.acts[row];
            let acts = act.acting.is_sound(self.space.activities());
            acts && self.check_order(id, &kept.orders[row]).is_ok() && kept.blocks[row / LANES].is_sound(row % LANES)
        };
        if !kept.roster.ids().iter().enumerate().all(|(row, &id)| can_be(row, id)) {
            return refuse("it has numbers that cannot be; it is damaged");
        }
        if !self.state.roster.restore(&kept.roster) {
            return refuse("its ids do not fit together; it is damaged");
        }
        self.state.bodies.clone_from(&kept.bodies);
        self.state.orders.clone_from(&kept.orders);
        self.state.ordered.clone_from(&kept.ordered);
        self.state.acts.clone_from(&kept.acts);
        self.state.blocks.clone_from(&kept.blocks);
        self.state.clear_free_lanes();
        self.events.clear(0.0);
        self.pose_again();
        Ok(())
    }

    /// Takes the blend space of the same name. Feet ease over; joint angles, which follow the new examples, change at
    /// once, and so do parameters where the space has other axes. Activities whose names are gone are given up.
    fn adopt(&mut self, new: &Bundle) -> Result<AdoptReport> {
        let space = new.blend(self.space.name())?;
        if self.is_database_body {
            config::check_body(space.skeleton())?;
            self.skeletons = vec![space.skeleton().clone()];
        }
        let kinds = |axes: &[crate::blend::AxisRecord]| axes.iter().map(|a| a.kind).collect::<Vec<_>>();
        if kinds(space.axes()) != kinds(self.space.axes()) {
            self.state.blocks.iter_mut().for_each(|block| block.placed = [0.0; LANES]);
        }
        let old = self.space.activities();
        self.state.acts.iter_mut().for_each(|act| act.acting.adopt(old, space.activities()));
        self.space = space;
        self.setup = self.find_setup(self.capacity());
        self.block_weights = vec![0.0; LANES * self.space.stride()];
        self.weights = Vec::with_capacity(self.capacity() * self.space.stride());
        let before = self.model.clone();
        self.pose_again();
        let joints = before.as_flattened().iter().zip(self.model.as_flattened());
        let apart = joints.map(|(a, b)| a.translation().distance(b.translation()));
        Ok(AdoptReport { num_characters: self.len(), farthest_m: apart.fold(0.0, f32::max) })
    }
}

impl WalkersState {
    /// Leaves free lanes as if nobody had ever been there.
    fn clear_free_lanes(&mut self) {
        for row in self.orders.len()..self.blocks.len() * LANES {
            self.blocks[row / LANES].copy_lane(row % LANES, &WalkerBlock::ZERO, 0);
        }
    }
}

impl Walkers {
    fn kind(&self) -> SnapshotKind {
        SnapshotKind { what: "walkers", tag: *b"WALK", version: 8, setup: self.setup }
    }

    /// Bodies and poses of all walkers, from the state.
    fn pose_again(&mut self) {
        self.bodies.clear();
        self.resize();
        (0..self.len()).for_each(|row| self.put_body(row));
        self.pose_rows(0..self.len());
    }
}
