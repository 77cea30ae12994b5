# nix build ./cmake/packaging/nix: the headers. nix develop ./cmake/packaging/nix: a shell with all that the tools need.
{
  description = "Fuses the depth images of several calibrated cameras into one point cloud, frame by frame";
  inputs.nixpkgs.url = "github:NixOS/nixpkgs/nixos-24.11";

  outputs = { self, nixpkgs }:
    let
      systems = [ "x86_64-linux" "aarch64-linux" ];
      forAll = make: nixpkgs.lib.genAttrs systems (system: make nixpkgs.legacyPackages.${system});
      off = map (part: "-DFUSE_FLOW_BUILD_${part}=OFF") [ "APPS" "TESTS" "GPU_TESTS" "BENCH" ];
      # The version stands in one place.
      version = builtins.head (builtins.match ".*project\\(FuseFlow VERSION ([0-9.]+).*" (builtins.readFile ../../../CMakeLists.txt));
    in {
      packages = forAll (pkgs: {
        default = pkgs.stdenv.mkDerivation {
          pname = "fuse-flow";
          inherit version;
          src = ../../..;
          nativeBuildInputs = [ pkgs.cmake pkgs.ninja pkgs.pkg-config ];
          propagatedBuildInputs = [ pkgs.pcl pkgs.eigen pkgs.flann ];
          cmakeFlags = off ++ [ "-DFUSE_FLOW_CUDA=OFF" "-DFUSE_FLOW_MPI=OFF" "-DFUSE_FLOW_PYTHON=OFF" ];
          meta.license = pkgs.lib.licenses.bsd3;
        };
      });
      devShells = forAll (pkgs: {
        default = pkgs.mkShell {
          packages = with pkgs; [
            cmake ninja pkg-config pcl eigen flann vtk libpng libjpeg libtiff zlib yaml-cpp nlohmann_json cli11 embree gtest gbenchmark
            boost openssl zstd lz4 sqlite ffmpeg openexr draco xorg.libX11 libGL (python3.withPackages (python: [ python.numpy python.pybind11 ]))
          ];
        };
      });
    };
}
