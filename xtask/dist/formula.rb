class Groundwave < Formula
  desc "Ground station for a small robot"
  homepage "@URL@"
  url "@URL@/groundwave-@VERSION@.tar.gz"
  sha256 "@SHA256@"
  license any_of: ["MIT", "Apache-2.0"]

  depends_on "rust" => :build

  def install
    system "cargo", "install", *std_cargo_args
    system bin/"groundwave", "man", man1
    generate_completions_from_executable(bin/"groundwave", "completions", shells: [:bash, :zsh, :fish])
  end

  test do
    assert_match version.to_s, shell_output("#{bin}/groundwave --version")
  end
end
