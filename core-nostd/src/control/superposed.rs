//! Scheme 2, (2.3): superposed control, as (2.2) with ΔX instead of SΔX.
//!
//! Both integrators act on depth, so at rest K_i J⁻¹ΔX + Jᵀn K_if Δf = 0 with n along z: a static
//! force error Δf = −(k̄_i/K_if) Δx, where Δx = nᵀΔX and k̄_i = 1/(nᵀJK_i⁻¹Jᵀn), in exchange for a
//! depth that keeps its stiffness when the sensor fails. The other directions give way with it:
//! ΔX = −K_if Δf · JK_i⁻¹Jᵀn has parts across n as well. Apart, the two integrators would wind up
//! against each other, so one set of joint integrators holds their sum, ∫(K_i J⁻¹ΔX + Jᵀn K_if Δf)
//! dt: the same law at rest, and bounded. Reconstructed (see the [module](super) text).

use super::parallel::Branches;

/// Superposed hybrid controller (2.3).
pub type Superposed<T> = Branches<T, false>;
