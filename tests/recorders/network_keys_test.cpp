// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/recorders/network_rig.h"

namespace trilat {
namespace {

using testing::HasSubstr;

TEST(TlsKeys, MakesASetThatOnlyItsOwnerMayRead) {
  const ScratchFolder folder;
  const auto made = make_tls_keys(folder / "keys", {"k1"});
  ASSERT_EQ(made.size(), 3u);
  for (const auto& path : made) {
    struct stat status {};
    ASSERT_EQ(::stat(path.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u) << path;
  }
  EXPECT_EQ(TlsIdentity(folder / "keys" / "k1.pem").name(), "k1");
  EXPECT_EQ(TlsIdentity(folder / "keys" / "server.pem").name(), kTlsServerName);
}

TEST(TlsKeys, AddsAgentsLaterAndOverwritesNothing) {
  const ScratchFolder folder;
  make_tls_keys(folder / "keys", {"k1"});
  const std::string before = read_file(folder / "keys" / "k1.pem");
  EXPECT_EQ(make_tls_keys(folder / "keys", {"k2"}).size(), 1u);
  EXPECT_THROW(make_tls_keys(folder / "keys", {"k3", "k1"}), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "keys" / "k3.pem"));
  EXPECT_EQ(read_file(folder / "keys" / "k1.pem"), before);
  EXPECT_TRUE(make_tls_keys(folder / "keys", {}).empty());
}

TEST(TlsKeys, NamesThatAreNoFileNamesOrTakenAreRefused) {
  const ScratchFolder folder;
  for (const char* name : {"", "a/b", "..", "ca", "server", "k 1"})
    EXPECT_THROW(make_tls_keys(folder / "keys", {name}), InputError) << name;
  EXPECT_THROW(make_tls_keys(folder / "keys", {"k1", "k1"}), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "keys"));
}

TEST(TlsKeys, AKeyFileThatOthersMayReadOrThatLacksAPartIsRefused) {
  const TestKeys keys;
  const auto path = keys.folder / "keys" / "k1.pem";
  ::chmod(path.c_str(), 0644);
  try {
    const TlsIdentity identity(path);
    FAIL() << "others may read it";
  } catch (const InputError& error) {
    EXPECT_THAT(error.problem(), HasSubstr("chmod 600"));
  }
  EXPECT_THROW(TlsIdentity(keys.folder / "keys" / "ca.pem"), InputError);
  EXPECT_THROW(TlsIdentity(keys.folder / "keys" / "none.pem"), InputError);
}

TEST(TlsKeys, AnAgentCannotPassForTheRecordingMachine) {
  const TestKeys keys;
  SocketListener listener({"127.0.0.1", 0});
  std::thread impostor([&] {
    auto accepted = listener.accept(kGenerous);
    try {
      secure_link(std::move(accepted->link), *keys.of("k2"), TlsSide::server, kGenerous);
    } catch (const std::runtime_error&) {
    }
  });
  EXPECT_THROW(connect_as(keys, "k1", listener.port())(), LinkRefused);
  impostor.join();
}

TEST(TlsKeys, AHandshakeThatNobodyWantsAnyMoreEnds) {
  const TestKeys keys;
  SocketListener listener({"127.0.0.1", 0});
  const auto mute = connect_socket({"127.0.0.1", listener.port()}, kGenerous);
  auto accepted = listener.accept(kGenerous);
  EXPECT_THROW(secure_link(std::move(accepted->link), *keys.of("server"), TlsSide::server, kGenerous,
                           [] { return true; }),
               LinkLost);
}

TEST(SocketAddress, IsHostAndPort) {
  EXPECT_EQ(parse_address("10.0.0.2:7345").host, "10.0.0.2");
  EXPECT_EQ(parse_address("10.0.0.2:7345").port, 7345);
  EXPECT_EQ(parse_address("[::1]:80").host, "::1");
  EXPECT_EQ(parse_address(":80").host, "");
  for (const char* text : {"", "host", "host:", "host:x", "host:65536", "::1", "host:-1", "host:80 "})
    EXPECT_THROW(parse_address(text), InputError) << text;
}

TEST(SocketAddress, OnlyLiteralAddressesAndLocalhostAreThisMachine) {
  for (const char* host : {"localhost", "127.0.0.1", "127.9.8.7", "::1", "::ffff:127.0.0.1"})
    EXPECT_TRUE(is_loopback({host, 1})) << host;
  for (const char* host :
       {"127.example.org", "127.0.0.1.nip.io", "", "10.0.0.1", "::", "127.", "::ffff:10.0.0.1"})
    EXPECT_FALSE(is_loopback({host, 1})) << host;
}

TEST(SocketAddress, PlainTextStaysOnThisMachineUnlessAllowed) {
  EXPECT_THROW(connect_to_server({"192.0.2.1", 1}, nullptr, false), InputError);
  EXPECT_NO_THROW(connect_to_server({"192.0.2.1", 1}, nullptr, true));
  ListenOptions listen;
  EXPECT_THROW(NetworkSource{listen}, InputError);
  listen.address = {"127.0.0.1", 0};
  NetworkSource network(listen);
  MadeSource source("kinect", made_events(20));
  RunningAgent agent(source, agent_options("k1"),
                     connect_to_server({"127.0.0.1", network.port()}, nullptr, false));
  network.wait_for_agents(1, kGenerous);
  EXPECT_EQ(receive_all(network).frames.size(), 20u);
}

}  // namespace
}  // namespace trilat
