//! The layout that the viewer opens with: the cell on the left, time series on the right, events below.
//!
//! Views are logged by their archetypes, since the typed layout of the Rust library has no camera, grid or axis range.

use super::writer::{RecordError, Store, Writer};
use super::{Shown, signals};
use nalgebra::{Rotation3, Vector3};
use rerun::datatypes::Uuid;
use rerun::external::re_sdk_types::blueprint::{archetypes as view, components as part};
use rerun::{AsComponents, TimePoint, Timeline};
use std::io::Write;

/// A container or view of the layout.
struct Node {
    entity: String,
    id: [u8; 16],
}

struct Layout<'a, W: Write> {
    writer: &'a mut Writer<W>,
    count: u32,
}

impl<W: Write> Layout<'_, W> {
    fn log(&mut self, entity: &str, what: &dyn AsComponents) -> Result<(), RecordError> {
        let when = TimePoint::default().with(Timeline::new_sequence("blueprint"), 0);
        self.writer.one(Store::Layout, entity, when, what)
    }

    fn node(&mut self, kind: &str) -> Node {
        self.count += 1;
        let mut id = [0; 16];
        id[6] = 0x40;
        id[8] = 0x80;
        id[12..].copy_from_slice(&self.count.to_be_bytes());
        Node { entity: format!("{kind}/00000000-0000-4000-8000-{:012x}", self.count), id }
    }

    fn view(
        &mut self,
        class: &str,
        name: &str,
        contents: &[String],
        properties: &[(&str, &dyn AsComponents)],
    ) -> Result<Node, RecordError> {
        let node = self.node("view");
        let query = contents.iter().map(|c| part::QueryExpression(c.as_str().into()));
        self.log(&format!("{}/ViewContents", node.entity), &view::ViewContents::new(query))?;
        let class = part::ViewClass(class.into());
        self.log(&node.entity, &view::ViewBlueprint::new(class).with_display_name(name).with_space_origin("/"))?;
        for (property, value) in properties {
            self.log(&format!("{}/{property}", node.entity), *value)?;
        }
        Ok(node)
    }

    fn container(&mut self, kind: part::ContainerKind, children: &[Node], shares: &[f32]) -> Result<Node, RecordError> {
        let node = self.node("container");
        let contents = children.iter().map(|c| part::IncludedContent(c.entity.as_str().into()));
        let mut container = view::ContainerBlueprint::new(kind).with_contents(contents);
        container = match kind {
            part::ContainerKind::Vertical => {
                container.with_row_shares(shares.iter().map(|s| part::RowShare((*s).into())))
            }
            part::ContainerKind::Horizontal => {
                container.with_col_shares(shares.iter().map(|s| part::ColumnShare((*s).into())))
            }
            _ => container,
        };
        self.log(&node.entity, &container)?;
        Ok(node)
    }
}

/// Writes the layout and makes it the active one.
pub(super) fn send<W: Write>(writer: &mut Writer<W>, shown: &[Shown], exaggeration: f64) -> Result<(), RecordError> {
    let mut layout = Layout { writer, count: 0 };
    let cell = cell(&mut layout, shown, exaggeration)?;
    let about = layout.view("TextDocument", "what is shown", &["/about".to_owned()], &[])?;
    let left = layout.container(part::ContainerKind::Vertical, &[cell, about], &[4.0, 1.0])?;

    let legend = view::PlotLegend::new().with_corner(part::Corner2D::RightTop);
    let mut plots = Vec::new();
    for group in signals::GROUPS {
        let mut contents: Vec<String> = Vec::new();
        let run_wise = if group.by_run { shown } else { shown.get(..1).unwrap_or_default() };
        for run in run_wise {
            contents.extend(group.entities.iter().map(|e| format!("/{}/{e}", run.root)));
        }
        contents.extend(group.references.iter().map(|e| format!("/reference/{e}")));
        let name = if group.by_run {
            group.title.to_owned()
        } else {
            format!("{}: {}", group.title, shown.first().map_or("", |s| s.name.as_str()))
        };
        plots.push(layout.view("TimeSeries", &name, &contents, &[("PlotLegend", &legend)])?);
    }
    let rest = plots.split_off(3.min(plots.len()));
    let tabs = layout.container(part::ContainerKind::Tabs, &rest, &[])?;
    let events: Vec<String> = shown.iter().map(|s| format!("/{}/events", s.root)).collect();
    let events = layout.view("TextLog", "events", &events, &[])?;
    plots.extend([tabs, events]);
    let right = layout.container(part::ContainerKind::Vertical, &plots, &[3.0, 3.0, 3.0, 3.0, 2.0])?;
    let root = layout.container(part::ContainerKind::Horizontal, &[left, right], &[5.0, 4.0])?;

    for panel in ["blueprint_panel", "selection_panel"] {
        layout.log(panel, &view::PanelBlueprint::new().with_state(part::PanelState::Hidden))?;
    }
    let time = view::TimePanelBlueprint::new()
        .with_state(part::PanelState::Collapsed)
        .with_timeline("time")
        .with_playback_speed(10.0)
        .with_play_state(part::PlayState::Following);
    layout.log("time_panel", &time)?;
    let viewport = view::ViewportBlueprint::new()
        .with_root_container(part::RootContainer(Uuid { bytes: root.id }))
        .with_auto_layout(false)
        .with_auto_views(false);
    layout.log("viewport", &viewport)?;
    layout.writer.activate_layout()
}

/// The view in space, its camera beside the seam and looking back at the arm.
fn cell<W: Write>(layout: &mut Layout<'_, W>, shown: &[Shown], exaggeration: f64) -> Result<Node, RecordError> {
    let seam = shown.first().and_then(|s| super::scene::Seam::of(&s.run.recording.rows));
    let middle = seam.map_or(Vector3::new(1.5, 0.0, 0.5), |s| s.middle());
    let outward = Vector3::new(middle.x, middle.y, 0.0).try_normalize(1e-6).unwrap_or_else(Vector3::x);
    let eye = middle + Rotation3::from_axis_angle(&Vector3::z_axis(), -0.75) * outward * 2.4 + Vector3::z() * 1.5;
    let target = middle - outward * 0.45 + Vector3::z() * 0.25;
    let eye = view::EyeControls3D::new()
        .with_position(eye.map(|v| v as f32).data.0[0])
        .with_look_target(target.map(|v| v as f32).data.0[0])
        .with_eye_up([0.0, 0.0, 1.0]);
    let grid = view::LineGrid3D::new().with_visible(true).with_spacing(0.5);
    let background =
        view::Background::new(part::BackgroundKind::SolidColor).with_color(rerun::Color::from_rgb(244, 245, 247));
    let title = match exaggeration {
        1.0 => "cell, to scale".to_owned(),
        factor => format!("cell: deviations drawn {factor:.0} × too large"),
    };
    let mut contents = vec!["/cell/**".to_owned()];
    contents.extend(shown.iter().map(|s| format!("/{}/cell/**", s.root)));
    layout.view("3D", &title, &contents, &[("EyeControls3D", &eye), ("LineGrid3D", &grid), ("Background", &background)])
}
