//! The list of the variables, in the order of their value references. Quantities of the plane are per metre of depth.

use adapter::{AXES, Dimensions, FlexibleNames, along_axes, either, per_depth};
use contact::{ContactCoupling, ContactExchange, Loads, Stations};

use crate::{ContactUnit, Coupling};

type Real = fmi_export::Real<ContactUnit>;
type Variable = fmi_export::Variable<ContactUnit>;

/// Return the variables of a unit.
pub fn of(unit: &ContactUnit) -> Vec<Variable> {
    match &unit.coupling {
        Dimensions::Plane(own) => list::<2>(unit, own),
        Dimensions::Space(own) => list::<3>(unit, own),
    }
}

/// The numbers of dimensions.
trait Counted<const D: usize>: rigid::Kinematics<D> {
    /// Return the contact, which is of this number.
    fn of(coupling: &mut Coupling) -> &mut ContactCoupling<D>
    where
        [f64; D]: rigid::Kinematics<D>;
}

impl Counted<2> for [f64; 2] {
    fn of(coupling: &mut Coupling) -> &mut ContactCoupling<2> {
        if let Coupling::Plane(own) = coupling { own } else { panic!("the list is that of the dimensions") }
    }
}

impl Counted<3> for [f64; 3] {
    fn of(coupling: &mut Coupling) -> &mut ContactCoupling<3> {
        if let Coupling::Space(own) = coupling { own } else { panic!("the list is that of the dimensions") }
    }
}

/// Return the contact of a unit, whose list is that of its dimensions.
fn own<const D: usize>(unit: &mut ContactUnit) -> &mut ContactCoupling<D>
where
    [f64; D]: Counted<D>,
{
    <[f64; D]>::of(&mut unit.coupling)
}

/// Return the list for D dimensions.
fn list<const D: usize>(unit: &ContactUnit, coupling: &ContactCoupling<D>) -> Vec<Variable>
where
    [f64; D]: Counted<D>,
{
    let text = "Energy of the contact between rods and wings";
    let energy = Real::computed("energy", per_depth(D, "J"), text, |m| either!(&m.coupling, own => own.energy()));
    let mut list = vec![Real::time(), energy.depends_on(&[])];
    for (k, stations) in coupling.target.iter().enumerate() {
        let names = FlexibleNames::of(&unit.scene, k);
        list.extend(exchange::<D>(&names, k));
        list.extend(exchanged::<D>(&names, k, stations.len()));
    }
    list
}

/// Return load, power and work of flexible body number `k`, to be compared with its own.
fn exchange<const D: usize>(FlexibleNames { name, stations, .. }: &FlexibleNames, k: usize) -> Vec<Variable>
where
    [f64; D]: Counted<D>,
{
    let output = |name: String, unit: &'static str, text: String, read: fn(&ContactExchange<D>) -> f64| {
        Real::computed(name, per_depth(D, unit), text, move |m| read(&own::<D>(m).exchange()[k])).depends_on(&[])
    };
    let mut list: Vec<_> = along_axes(D, |d, axis| {
        let text = format!("Sum of what contact exerted on the {stations} along {axis}");
        let read = move |m: &mut ContactUnit| own::<D>(m).exchange()[k].force[d];
        Real::computed(format!("{name}.load_{axis}"), per_depth(D, "N"), text, read).depends_on(&[])
    })
    .collect();
    let text = format!("Power of what contact exerted on the {stations}, at the end of the step");
    list.push(output(format!("{name}.power"), "W", text, |exchange| exchange.power));
    let text = "Its work since the start: the sum of power times step";
    list.push(output(format!("{name}.work"), "J", text.into(), |exchange| exchange.work));
    list
}

/// Return the variables of the `n` stations of flexible body number `k`: their motion and their loads.
fn exchanged<const D: usize>(
    FlexibleNames { prefix, stations, .. }: &FlexibleNames,
    k: usize,
    n: usize,
) -> Vec<Variable>
where
    [f64; D]: Counted<D>,
{
    let mut list = Vec::new();
    let mut input = |name: &str, unit: &str, what: &str, of: fn(&mut Stations<D>) -> &mut [Vec<f64>; D]| {
        list.extend(AXES.into_iter().enumerate().take(D).map(|(axis, along)| {
            let text = format!("{what} of the {stations} at the end of the step");
            let variable = Real::input(format!("{prefix}{name}{along}"), unit, text, move |m| {
                &mut of(&mut own::<D>(m).target[k])[axis]
            });
            variable.array(n)
        }));
    };
    input("", "m", "Position", |stations| &mut stations.position);
    input("v", "m/s", "Velocity", |stations| &mut stations.velocity);
    let mut output = |name: String, unit: &'static str, text: String, of: fn(&Loads<D>, usize) -> &Vec<f64>, axis| {
        let variable = Real::output(name, per_depth(D, unit), text, move |m| of(&own::<D>(m).loads()[k], axis));
        list.push(variable.array(n).depends_on(&[]));
    };
    for (axis, along) in AXES.into_iter().enumerate().take(D) {
        let text = format!("Load on the {stations} for the coming step");
        output(format!("{prefix}force_{along}"), "N", text, |loads, axis| &loads.force[axis], axis);
    }
    let of = if D == 2 { "station" } else { "node" };
    let text = format!("Rate at which the load falls with the {of}'s velocity");
    output(format!("{prefix}impedance"), "kg/s", text, |loads, _| &loads.impedance, 0);
    list
}
