# SPDX-License-Identifier: Apache-2.0
# The command line with all formats, for any x86-64 or AArch64:
#   docker build -t tetune .
#   docker run --rm --user "$(id -u):$(id -g)" --volume "$PWD:/mesh" tetune optimize in.mesh out.meshb
FROM debian:12-slim AS build
WORKDIR /source
COPY scripts/install-packages scripts/
# As scripts/demo --all-formats.
RUN scripts/install-packages g++ cmake ninja-build libcli11-dev libfmt-dev nlohmann-json3-dev libtomlplusplus-dev zlib1g-dev libvtk9-dev libgmsh-dev libocct-data-exchange-dev
COPY . .
RUN cmake --preset release -DBUILD_SHARED_LIBS=ON -DTETUNE_TESTS=OFF -DTETUNE_EXAMPLES=OFF -DTETUNE_MPI=OFF \
    && cmake --build --preset release \
    && DESTDIR=/installed cmake --install build/release --strip

FROM debian:12-slim
RUN --mount=type=bind,from=build,source=/source/scripts,target=/scripts \
    /scripts/install-packages libfmt9 libgmsh4.8 libocct-data-exchange-7.6 libtomlplusplus3 libvtk9.1 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --uid 1000 --create-home tetune
COPY --from=build /installed/usr/local /usr/local
USER 1000
WORKDIR /mesh
ENTRYPOINT ["tetune"]
CMD ["--help"]
