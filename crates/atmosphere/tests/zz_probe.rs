mod common;
use niji_atmosphere::*;
use niji_radiometry::Radians;
#[test]
fn probe() {
    let mut air = common::unit_sun_air(vec![AirComponent::STANDARD_RAYLEIGH, AirComponent::Ozone(OzoneLayer::of_column(300.0)), AirComponent::Aerosol(AerosolKind::Rural.aerosol())]);
    air.ground_albedo = vec![0.2; 3];
    for sun in [5.0, 0.0, -4.0] { for tol in [1e-3, 3e-4, 1e-4] {
        let d = SkyDome::new(&air, SkyObserver::from_elevation(2.0, Radians::from_degrees(sun)), tol);
        println!("sun {sun} tol {tol:e} rays {} {:?}", d.n_rays(), d.shape());
    }}
}
